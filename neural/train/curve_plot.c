#include "neural/train/curve_plot.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/image/font.h"
#include "engine/image/oiio.h"
#include "neural/train/curve.h"

enum {
    WIDTH = 960,
    HEIGHT = 540,
    LEFT = 96, /* of the axes */
    RIGHT = WIDTH - 28,
    TOP = 56,
    BOTTOM = HEIGHT - 60,
    SCALE = 2, /* pixels a font pixel */
    ADVANCE = (PBNDS_FONT_WIDTH + 1) * SCALE,
    LINE = PBNDS_FONT_HEIGHT * SCALE
};

struct color {
    float rgb[3];
};
static const struct color PAPER = {{1.0f, 1.0f, 1.0f}}, INK = {{0.15f, 0.15f, 0.15f}},
                          GRID = {{0.87f, 0.87f, 0.87f}},
                          TRAIN = {{0.45f, 0.62f, 0.83f}},
                          VAL = {{0.80f, 0.28f, 0.10f}};

/* What the axes show. */
struct plot {
    struct pbnds_image image;
    double steps;  /* right end */
    double lo, hi; /* ln of the losses */
};

static void blend(struct plot *p, int x, int y, float share, struct color color)
{
    if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT) return;
    float *pixel = pbnds_image_at(&p->image, x, y);
    for (int c = 0; c < 3; ++c)
        pixel[c] += share * (color.rgb[c] - pixel[c]);
}

static void bar(struct plot *p, int x0, int y0, int width, int height,
                struct color color)
{
    for (int y = y0; y < y0 + height; ++y) {
        for (int x = x0; x < x0 + width; ++x)
            blend(p, x, y, 1.0f, color);
    }
}

static void text(struct plot *p, int x, int y, const char *words, struct color color)
{
    for (; *words; ++words, x += ADVANCE) {
        const int code = (unsigned char)*words;
        const bool known = code >= PBNDS_FONT_FIRST && code <= PBNDS_FONT_LAST;
        const unsigned char *rows = pbnds_font[(known ? code : '?') - PBNDS_FONT_FIRST];
        const int down = strchr("gpqy", code) ? PBNDS_FONT_DESCENT * SCALE : 0;
        for (int r = 0; r < PBNDS_FONT_HEIGHT; ++r) {
            for (int c = 0; c < PBNDS_FONT_WIDTH; ++c) {
                if (rows[r] >> (PBNDS_FONT_WIDTH - 1 - c) & 1)
                    bar(p, x + c * SCALE, y + r * SCALE + down, SCALE, SCALE, color);
            }
        }
    }
}

static int text_width(const char *words)
{
    return (int)strlen(words) * ADVANCE - SCALE;
}

static double place_x(const struct plot *p, double step)
{
    return LEFT + (RIGHT - LEFT) * step / p->steps;
}

static double place_y(const struct plot *p, double loss)
{
    return BOTTOM - (BOTTOM - TOP) * (log(loss) - p->lo) / (p->hi - p->lo);
}

/* A line two pixels wide, its rim by the distance to it. */
static void line(struct plot *p, double x0, double y0, double x1, double y1,
                 struct color color)
{
    const double dx = x1 - x0, dy = y1 - y0;
    const double length2 = fmax(dx * dx + dy * dy, 1e-12);
    for (int y = (int)fmin(y0, y1) - 2; y <= (int)fmax(y0, y1) + 2; ++y) {
        for (int x = (int)fmin(x0, x1) - 2; x <= (int)fmax(x0, x1) + 2; ++x) {
            const double px = x + 0.5 - x0, py = y + 0.5 - y0;
            const double t = fmin(fmax((px * dx + py * dy) / length2, 0.0), 1.0);
            const double distance = hypot(px - t * dx, py - t * dy);
            const double share = fmin(fmax(1.5 - distance, 0.0), 1.0);
            if (share > 0.0) blend(p, x, y, (float)share, color);
        }
    }
}

static bool shows(double loss)
{
    return isfinite(loss) && loss > 0.0;
}

static double loss_of(const struct pbnds_curve_row *row, bool val)
{
    return val ? row->val_loss : row->loss;
}

static void fit(struct plot *p, const struct pbnds_curve_row *rows, int count)
{
    double least = HUGE_VAL, most = 0.0;
    for (int i = 0; i < 2 * count; ++i) {
        const double loss = loss_of(&rows[i / 2], i % 2 == 1);
        if (!shows(loss)) continue;
        least = fmin(least, loss);
        most = fmax(most, loss);
    }
    if (most <= 0.0) least = most = 1.0;
    p->steps = count > 0 ? fmax((double)rows[count - 1].step, 1.0) : 1.0;
    p->lo = log(least) - 0.08;
    p->hi = log(most) + 0.08;
    const double narrow = 0.5 * (log(1.3) - (p->hi - p->lo)); /* not all noise */
    if (narrow > 0.0) {
        p->lo -= narrow;
        p->hi += narrow;
    }
}

/* 1, 2 or 5 times a power of ten, so that about six of them are x. */
static double nice_step(double x)
{
    const double raw = fmax(x / 6.0, 1.0), power = pow(10.0, floor(log10(raw)));
    const double lead = raw / power;
    return power * (lead <= 1.0 ? 1.0 : lead <= 2.0 ? 2.0 : lead <= 5.0 ? 5.0 : 10.0);
}

static void step_axis(struct plot *p)
{
    const double every = nice_step(p->steps);
    for (double step = 0.0; step <= p->steps * 1.0001; step += every) {
        const int x = (int)place_x(p, step);
        char label[32];
        (void)snprintf(label, sizeof label, "%.0f", step);
        bar(p, x, TOP, 1, BOTTOM - TOP, GRID);
        bar(p, x, BOTTOM, 1, 6, INK);
        const int middle = x - text_width(label) / 2;
        const int most = WIDTH - 4 - text_width(label);
        text(p, middle < most ? middle : most, BOTTOM + 12, label, INK);
    }
    text(p, (LEFT + RIGHT - text_width("step")) / 2, HEIGHT - LINE - 6, "step", INK);
}

/* Of each decade as many marks as have room for their labels: the last list that has. */
static void loss_axis(struct plot *p)
{
    static const double MARKS[][11] = {
        {1.0},
        {1.0, 3.0},
        {1.0, 2.0, 5.0},
        {1.0, 1.5, 2.0, 3.0, 5.0, 7.0},
        {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0},
    };
    static const double CLOSEST[] = {10.0, 3.0, 2.0, 1.333, 1.2}; /* of neighbours */
    const double pixels = (BOTTOM - TOP) / (p->hi - p->lo);
    int list = 0;
    while (list < 4 && log(CLOSEST[list + 1]) * pixels > 1.6 * LINE)
        ++list;
    const double first = pow(10.0, floor(p->lo / log(10.0)));
    const double skip = log(10.0) * pixels > 1.6 * LINE
                            ? 10.0
                            : pow(10.0, ceil(1.6 * LINE / (log(10.0) * pixels)));
    for (double decade = first; log(decade) < p->hi; decade *= skip) {
        for (int k = 0; k < 11 && MARKS[list][k] > 0.0; ++k) {
            const double loss = decade * MARKS[list][k];
            if (log(loss) < p->lo || log(loss) > p->hi) continue;
            const int y = (int)place_y(p, loss);
            char label[32];
            (void)snprintf(label, sizeof label, "%.3g", loss);
            bar(p, LEFT, y, RIGHT - LEFT, 1, GRID);
            bar(p, LEFT - 6, y, 6, 1, INK);
            text(p, LEFT - 12 - text_width(label), y - LINE / 2, label, INK);
        }
    }
}

static void curve(struct plot *p, const struct pbnds_curve_row *rows, int count,
                  bool val, struct color color)
{
    double from_x = 0.0, from_y = 0.0;
    bool joined = false;
    for (int i = 0; i < count; ++i) {
        const double loss = loss_of(&rows[i], val);
        if (shows(loss)) {
            const double x = place_x(p, (double)rows[i].step), y = place_y(p, loss);
            line(p, joined ? from_x : x, joined ? from_y : y, x, y, color);
            from_x = x;
            from_y = y;
        }
        joined = shows(loss);
    }
}

/* The best validation, in words and as a dot. */
static void heading(struct plot *p, const struct pbnds_curve_row *rows, int count)
{
    const struct pbnds_curve_row *best = NULL;
    for (int i = 0; i < count; ++i) {
        if (shows(rows[i].val_loss) && (!best || rows[i].val_loss < best->val_loss))
            best = &rows[i];
    }
    char words[96] = "loss";
    if (best) {
        (void)snprintf(words, sizeof words,
                       "loss, best val %.4g (%.2f dB) at step %.0f", best->val_loss,
                       best->val_psnr, (double)best->step);
        const int x = (int)place_x(p, (double)best->step);
        const int y = (int)place_y(p, best->val_loss);
        bar(p, x - 4, y - 4, 9, 9, PAPER);
        bar(p, x - 3, y - 3, 7, 7, VAL);
    }
    text(p, 12, 18, words, INK);
    text(p, RIGHT - text_width("train"), 18, "train", TRAIN);
    text(p, RIGHT - text_width("val  train"), 18, "val", VAL);
}

static void draw(struct plot *p, const struct pbnds_curve_row *rows, int count)
{
    bar(p, 0, 0, WIDTH, HEIGHT, PAPER);
    fit(p, rows, count);
    step_axis(p);
    loss_axis(p);
    bar(p, LEFT, TOP, 1, BOTTOM - TOP, INK);
    bar(p, LEFT, BOTTOM, RIGHT - LEFT, 1, INK);
    curve(p, rows, count, false, TRAIN);
    curve(p, rows, count, true, VAL);
    heading(p, rows, count);
}

enum pbnds_status pbnds_curve_plot(const char *csv, const char *png,
                                   struct pbnds_error *error)
{
    struct pbnds_curve_row *rows;
    int count;
    struct plot plot;
    PBNDS_TRY(pbnds_curve_read(csv, &rows, &count, error));
    enum pbnds_status status = pbnds_image_init(&plot.image, WIDTH, HEIGHT, 3, error);
    if (status == PBNDS_OK) {
        draw(&plot, rows, count);
        status = pbnds_png_write(png, &plot.image, error);
        pbnds_image_free(&plot.image);
    }
    free(rows);
    return status;
}
