#include "tools/shaders.h"

#include <stdio.h>
#include <string.h>

#include "neural/shader_neural.h"
#include "tools/shipped.h"

/* The weights that ship, by the names of the command line. */
static const struct {
    const char *name, *file, *about;
} shipped[] = {
    {"neural", "weights/transport.safetensors",
     "the shipped default: the same as transport"},
    {"transport", "weights/transport.safetensors",
     "structured network, linear in light: GGX x visibility + indirect"},
    {"pbnds+", "weights/pbnds_plus.safetensors",
     "the U-Net of the paper, a light at a time"},
};
enum { SHIPPED_COUNT = sizeof shipped / sizeof shipped[0] };

static const char prefix[] = "neural:";
enum { PREFIX_LENGTH = sizeof prefix - 1 };

static bool is_file(const char *name)
{
    return strncmp(name, prefix, PREFIX_LENGTH) == 0 && name[PREFIX_LENGTH];
}

static int find_shipped(const char *name)
{
    for (int i = 0; i < SHIPPED_COUNT; ++i) {
        if (strcmp(shipped[i].name, name) == 0) return i;
    }
    return -1;
}

enum pbnds_status tool_shader_check(const char *name, struct pbnds_error *error)
{
    if (is_file(name) || find_shipped(name) >= 0 || pbnds_shader_find(name))
        return PBNDS_OK;
    char list[256] = "";
    size_t used = 0;
    for (int i = 0; pbnds_shader_at(i) && used < sizeof list; ++i) {
        used += (size_t)snprintf(list + used, sizeof list - used, "%s, ",
                                 pbnds_shader_at(i)->ops->name);
    }
    return pbnds_fail(
        error, PBNDS_ERROR_ARGUMENT,
        "'%s' is not a shader of this version; there are %sneural, transport, "
        "pbnds+ and neural:FILE",
        name, list);
}

enum pbnds_status tool_shader_open(const char *name, int precision,
                                   struct tool_shader *shader,
                                   struct pbnds_error *error)
{
    *shader = (struct tool_shader){NULL, false};
    PBNDS_TRY(tool_shader_check(name, error));
    shader->shader = pbnds_shader_find(name);
    if (shader->shader) return PBNDS_OK;
    char found[1400];
    const char *path = name + PREFIX_LENGTH;
    if (!is_file(name)) {
        if (!tool_shipped(shipped[find_shipped(name)].file, found, sizeof found)) {
            return pbnds_fail(
                error, PBNDS_ERROR_IO,
                "%s: the weights of '%s' are not installed; give neural:FILE", found,
                name);
        }
        path = found;
    }
    const bool bf16 =
        precision == TOOL_PRECISION_BF16 ||
        (precision == TOOL_PRECISION_AUTO && pbnds_backend_has_fast_bf16());
    PBNDS_TRY(pbnds_shader_neural_create(path, bf16 ? PBNDS_BF16 : PBNDS_F32,
                                         &shader->shader, error));
    shader->owned = true;
    return PBNDS_OK;
}

void tool_shader_close(struct tool_shader *shader)
{
    if (shader->owned) pbnds_shader_neural_free(shader->shader);
    *shader = (struct tool_shader){NULL, false};
}

static void help_line(const char *name, const char *about)
{
    (void)printf("  %-19s ", name);
    tool_print_wrapped(about, 22);
}

void tool_shaders_help(void)
{
    (void)printf("\nShaders\n");
    for (int i = 0; pbnds_shader_at(i); ++i) {
        help_line(pbnds_shader_at(i)->ops->name, pbnds_shader_at(i)->ops->about);
    }
    for (int i = 0; i < SHIPPED_COUNT; ++i)
        help_line(shipped[i].name, shipped[i].about);
    help_line("neural:FILE", "any weights file; the file says its model");
}
