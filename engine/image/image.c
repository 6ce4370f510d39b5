#include "engine/image/image.h"

#include <stdint.h>
#include <stdlib.h>

enum { SIDE_MAX = 65535, CHANNELS_MAX = 64 };

enum pbnds_status pbnds_image_init(struct pbnds_image *image, int width, int height,
                                   int channels, struct pbnds_error *error)
{
    *image = (struct pbnds_image){0, 0, 0, NULL};
    if (width < 1 || width > SIDE_MAX || height < 1 || height > SIDE_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "image of %d x %d pixels: sides must lie in [1, %d]", width,
                          height, SIDE_MAX);
    }
    if (channels < 1 || channels > CHANNELS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "image of %d channels: there must be 1 to %d", channels,
                          CHANNELS_MAX);
    }
    const size_t count = (size_t)width * (size_t)height * (size_t)channels;
    float *data = calloc(count, sizeof *data);
    if (!data) {
        return pbnds_fail(
            error, PBNDS_ERROR_MEMORY,
            "image of %d x %d pixels and %d channels: no memory for %zu bytes", width,
            height, channels, count * sizeof *data);
    }
    *image = (struct pbnds_image){width, height, channels, data};
    return PBNDS_OK;
}

void pbnds_image_free(struct pbnds_image *image)
{
    free(image->data);
    *image = (struct pbnds_image){0, 0, 0, NULL};
}

/* One axis of the box filter. Lengths are counted in 1/to of a source pixel, so that
 * the overlaps are whole numbers and the weights of a target pixel sum to one exactly:
 * target pixel i covers [i from, (i + 1) from), source pixel k covers [k to, (k + 1)
 * to).
 */
struct axis {
    int64_t from, to;     /* pixels of the source and of the target             */
    size_t step_in, step; /* floats between pixels along the axis, in and out   */
    size_t lines;         /* lines along the axis                               */
    size_t line_in, line; /* floats between the starts of two lines, in and out */
};

static void average_pixel(const float *in, const struct axis *a, int64_t i,
                          int channels, float *out)
{
    const int64_t begin = i * a->from, end = begin + a->from;
    double sum[CHANNELS_MAX] = {0.0};
    for (int64_t k = begin / a->to; k * a->to < end; ++k) {
        const int64_t left = k * a->to > begin ? k * a->to : begin;
        const int64_t right = (k + 1) * a->to < end ? (k + 1) * a->to : end;
        const double weight = (double)(right - left) / (double)a->from;
        const float *pixel = in + (size_t)k * a->step_in;
        for (int c = 0; c < channels; ++c)
            sum[c] += weight * (double)pixel[c];
    }
    for (int c = 0; c < channels; ++c)
        out[c] = (float)sum[c];
}

static void average_axis(const float *in, const struct axis *a, int channels,
                         float *out)
{
    for (size_t l = 0; l < a->lines; ++l) {
        for (int64_t i = 0; i < a->to; ++i) {
            average_pixel(in + l * a->line_in, a, i, channels,
                          out + l * a->line + (size_t)i * a->step);
        }
    }
}

enum pbnds_status pbnds_image_resize(const struct pbnds_image *src, int width,
                                     int height, struct pbnds_image *dst,
                                     struct pbnds_error *error)
{
    *dst = (struct pbnds_image){0, 0, 0, NULL};
    struct pbnds_image narrow, out;
    PBNDS_TRY(pbnds_image_init(&narrow, width, src->height, src->channels, error));
    const enum pbnds_status status =
        pbnds_image_init(&out, width, height, src->channels, error);
    if (status == PBNDS_OK) {
        const size_t pixel = (size_t)src->channels;
        const size_t row_in = (size_t)src->width * pixel, row = (size_t)width * pixel;
        const struct axis across = {.from = src->width,
                                    .to = width,
                                    .step_in = pixel,
                                    .step = pixel,
                                    .lines = (size_t)src->height,
                                    .line_in = row_in,
                                    .line = row};
        const struct axis down = {.from = src->height,
                                  .to = height,
                                  .step_in = row,
                                  .step = row,
                                  .lines = (size_t)width,
                                  .line_in = pixel,
                                  .line = pixel};
        average_axis(src->data, &across, src->channels, narrow.data);
        average_axis(narrow.data, &down, src->channels, out.data);
        *dst = out;
    }
    pbnds_image_free(&narrow);
    return status;
}
