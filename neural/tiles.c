#include "neural/tiles.h"

static const size_t DEFAULT_MEMORY = (size_t)1 << 30;

static int rounded_up(int x, int unit)
{
    return (x + unit - 1) / unit * unit;
}

/* One axis: about n windows over `domain` pixels. */
static void divide(int domain, int halo, int unit, int n, int *window, int *step,
                   int *count)
{
    const int inner = domain - 2 * halo;
    if (n <= 1 || inner <= unit) {
        *window = *step = domain;
        *count = 1;
        return;
    }
    *step = rounded_up((inner + n - 1) / n, unit);
    *count = (inner + *step - 1) / *step;
    *window = *count > 1 ? *step + 2 * halo : domain;
}

static int most_along(int domain, int halo, int unit)
{
    const int inner = domain - 2 * halo;
    return inner > unit ? inner / unit : 1;
}

static void cut(struct pbnds_tiling *t, int unit, int columns, int rows)
{
    divide(t->domain_width, t->halo, unit, columns, &t->window_width, &t->step_x,
           &t->columns);
    divide(t->domain_height, t->halo, unit, rows, &t->window_height, &t->step_y,
           &t->rows);
}

/* The cheapest cut whose windows have at most `most` pixels; else the smallest windows.
 */
static void choose(struct pbnds_tiling *t, int unit, double most)
{
    const int columns = most_along(t->domain_width, t->halo, unit);
    const int rows = most_along(t->domain_height, t->halo, unit);
    double best = -1.0;
    struct pbnds_tiling chosen = *t;
    cut(&chosen, unit, columns, rows);
    for (int y = 1; y <= rows; ++y) {
        for (int x = 1; x <= columns; ++x) {
            struct pbnds_tiling tried = *t;
            cut(&tried, unit, x, y);
            const double pixels =
                (double)tried.window_width * (double)tried.window_height;
            const double cost = pixels * (double)tried.columns * (double)tried.rows;
            if (pixels > most || (best >= 0.0 && cost >= best)) continue;
            best = cost;
            chosen = tried;
        }
    }
    *t = chosen;
}

struct pbnds_tiling pbnds_tiling_plan(const struct pbnds_net *net, int width,
                                      int height, int lights, size_t max_memory,
                                      pbnds_tile_bytes bytes, const void *context)
{
    const int unit = 1 << pbnds_net_deepest_level(net);
    const size_t budget = max_memory ? max_memory : DEFAULT_MEMORY;
    struct pbnds_tiling t = {.width = width,
                             .height = height,
                             .halo = pbnds_net_halo(net),
                             .domain_width = rounded_up(width, unit),
                             .domain_height = rounded_up(height, unit),
                             .chunk = 1};
    double most = (double)t.domain_width * (double)t.domain_height;
    for (;;) {
        choose(&t, unit, most);
        const double pixels = (double)t.window_width * (double)t.window_height;
        t.bytes = bytes(context, t.window_width, t.window_height, 1);
        if (t.bytes <= budget || pixels > most) break;
        /* Memory is nearly linear in pixels: aim at what fits, and a little lower. */
        const double fit = pixels * (double)budget / (double)t.bytes;
        most = fit < 0.97 * pixels ? fit : 0.97 * pixels;
    }
    while (t.chunk < PBNDS_CHUNK_MAX && t.chunk < lights) {
        const size_t more =
            bytes(context, t.window_width, t.window_height, t.chunk + 1);
        if (more > budget) break;
        t.bytes = more;
        ++t.chunk;
    }
    return t;
}

/* One axis of a tile, in pixels of the domain. */
static void along(int k, int count, int step, int window, int halo, int domain,
                  int *start, int *own, int *own_end)
{
    *start = k * step < domain - window ? k * step : domain - window;
    *own = k == 0 ? 0 : k * step + halo;
    *own_end = k == count - 1 ? domain : (k + 1) * step + halo;
}

struct pbnds_tile pbnds_tiling_tile(const struct pbnds_tiling *t, int i)
{
    int x, y, left, top, right, bottom;
    along(i % t->columns, t->columns, t->step_x, t->window_width, t->halo,
          t->domain_width, &x, &left, &right);
    along(i / t->columns, t->rows, t->step_y, t->window_height, t->halo,
          t->domain_height, &y, &top, &bottom);
    right = right < t->width ? right : t->width;
    bottom = bottom < t->height ? bottom : t->height;
    return (struct pbnds_tile){
        .window = {x, y, t->window_width, t->window_height},
        .own = {left, top, right - left, bottom - top},
    };
}
