/* Field numbers and values: onnx/onnx.proto of IR version 7; operators: opset 13 of
 * https://onnx.ai/onnx/operators. The messages are written inside out: a field of a
 * message is complete when it is put into it. */
#include "neural/model/onnx.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/model/protobuf.h"

enum { IR_VERSION = 7, OPSET = 13, TYPE_FLOAT = 1, TYPE_INT64 = 7 };
enum { /* ModelProto */
       MODEL_IR = 1,
       MODEL_PRODUCER = 2,
       MODEL_PRODUCER_VERSION = 3,
       MODEL_VERSION = 5,
       MODEL_DOC = 6,
       MODEL_GRAPH = 7,
       MODEL_OPSET = 8,
       MODEL_METADATA = 14
};
enum { /* GraphProto */
       GRAPH_NODE = 1,
       GRAPH_NAME = 2,
       GRAPH_TENSOR = 5,
       GRAPH_INPUT = 11,
       GRAPH_OUTPUT = 12
};
enum {
    NODE_INPUT = 1,
    NODE_OUTPUT = 2,
    NODE_NAME = 3,
    NODE_OP = 4,
    NODE_ATTRIBUTE = 5
};
enum { /* AttributeProto, and its types */
       ATTRIBUTE_NAME = 1,
       ATTRIBUTE_INT = 3,
       ATTRIBUTE_STRING = 4,
       ATTRIBUTE_INTS = 8,
       ATTRIBUTE_TYPE = 20,
       KIND_INT = 2,
       KIND_STRING = 3,
       KIND_INTS = 7
};
enum { TENSOR_DIM = 1, TENSOR_TYPE = 2, TENSOR_NAME = 8, TENSOR_RAW = 9 };

static const char VIEW_INPUT[] = "view_input", LIGHT_INPUT[] = "light_input";
static const char VIEW_OUTPUT[] = "view_output", LIGHT_OUTPUT[] = "light_output";
/* The shape [N, 1, 1, 1], to which a view's tensor is broadcast before it is joined to a
 * light's. Add does that by itself. */
static const char LIGHTS_SHAPE[] = "lights/shape";

struct name {
    char text[128];
};

struct exporter {
    const struct pbnds_net_table *table;
    const struct pbnds_net *net;
    struct pbnds_proto graph;
    bool has_lights_shape;
};

/* ---- nodes ---- */

static struct pbnds_proto begin_node(const char *op, const char *name)
{
    struct pbnds_proto node = {0};
    pbnds_proto_string(&node, NODE_OP, op);
    pbnds_proto_string(&node, NODE_NAME, name);
    return node;
}

static void end_node(struct exporter *e, struct pbnds_proto *node, const char *output)
{
    pbnds_proto_string(node, NODE_OUTPUT, output);
    pbnds_proto_message(&e->graph, GRAPH_NODE, node);
}

static void put_int(struct pbnds_proto *node, const char *name, int64_t value)
{
    struct pbnds_proto a = {0};
    pbnds_proto_string(&a, ATTRIBUTE_NAME, name);
    pbnds_proto_int(&a, ATTRIBUTE_TYPE, KIND_INT);
    pbnds_proto_int(&a, ATTRIBUTE_INT, value);
    pbnds_proto_message(node, NODE_ATTRIBUTE, &a);
}

static void put_ints(struct pbnds_proto *node, const char *name, int count,
                     const int *values)
{
    struct pbnds_proto a = {0};
    pbnds_proto_string(&a, ATTRIBUTE_NAME, name);
    pbnds_proto_int(&a, ATTRIBUTE_TYPE, KIND_INTS);
    for (int i = 0; i < count; ++i)
        pbnds_proto_int(&a, ATTRIBUTE_INTS, values[i]);
    pbnds_proto_message(node, NODE_ATTRIBUTE, &a);
}

static void put_string(struct pbnds_proto *node, const char *name, const char *value)
{
    struct pbnds_proto a = {0};
    pbnds_proto_string(&a, ATTRIBUTE_NAME, name);
    pbnds_proto_int(&a, ATTRIBUTE_TYPE, KIND_STRING);
    pbnds_proto_string(&a, ATTRIBUTE_STRING, value);
    pbnds_proto_message(node, NODE_ATTRIBUTE, &a);
}

static void put_windows(struct pbnds_proto *node, int kernel, int stride)
{
    put_ints(node, "kernel_shape", 2, (const int[]){kernel, kernel});
    put_ints(node, "strides", 2, (const int[]){stride, stride});
}

/* ---- tensors ---- */

static void put_tensor(struct exporter *e, const char *name, int type, int rank,
                       const int *shape, const void *data, size_t size)
{
    struct pbnds_proto t = {0};
    for (int i = 0; i < rank; ++i)
        pbnds_proto_int(&t, TENSOR_DIM, shape[i]);
    pbnds_proto_int(&t, TENSOR_TYPE, type);
    pbnds_proto_string(&t, TENSOR_NAME, name);
    pbnds_proto_bytes(&t, TENSOR_RAW, data, size); /* little-endian, as here */
    pbnds_proto_message(&e->graph, GRAPH_TENSOR, &t);
}

static void put_int64s(struct exporter *e, const char *name, int count,
                       const int64_t *values)
{
    put_tensor(e, name, TYPE_INT64, 1, &count, values, (size_t)count * sizeof *values);
}

/* The parameters of used rows: "<row>.weight" and "<row>.bias". */
static void put_parameters(struct exporter *e)
{
    /* read only: the net is not changed by asking for them */
    const float *params = pbnds_net_params((struct pbnds_net *)(uintptr_t)e->net);
    int i = 0;
    for (int r = 0; r < e->table->layer_count; ++r) {
        const enum pbnds_op op = e->table->layers[r].op;
        if (op != PBNDS_OP_CONV && op != PBNDS_OP_UP) continue;
        for (int k = 0; k < 2; ++k, ++i) {
            const struct pbnds_param *p = pbnds_net_param(e->net, i);
            if (!pbnds_net_row_facts(e->net, r).used) continue;
            put_tensor(e, p->name, TYPE_FLOAT, p->rank, p->shape, params + p->offset,
                       p->count * sizeof *params);
        }
    }
}

/* ---- rows ---- */

/* What a row's output is called in the graph. */
static struct name value_name(const struct exporter *e, int r)
{
    const struct pbnds_layer *layer = &e->table->layers[r];
    struct name name;
    if (layer->op == PBNDS_OP_DROPOUT) return value_name(e, layer->in[0]);
    if (layer->op == PBNDS_OP_VIEW_INPUT || layer->op == PBNDS_OP_LIGHT_INPUT) {
        (void)snprintf(name.text, sizeof name.text, "%s",
                       layer->op == PBNDS_OP_VIEW_INPUT ? VIEW_INPUT : LIGHT_INPUT);
    } else {
        (void)snprintf(name.text, sizeof name.text, "/%.96s", layer->name);
    }
    return name;
}

static void put_lights_shape(struct exporter *e)
{
    static const int64_t ZERO = 0, ONE = 1, ONES[3] = {1, 1, 1};
    put_int64s(e, "lights/first", 1, &ZERO);
    put_int64s(e, "lights/end", 1, &ONE);
    put_int64s(e, "lights/ones", 3, ONES);
    struct pbnds_proto node = begin_node("Shape", "lights/input_shape");
    pbnds_proto_string(&node, NODE_INPUT, LIGHT_INPUT);
    end_node(e, &node, "lights/input_shape");
    node = begin_node("Slice", "lights/count");
    pbnds_proto_string(&node, NODE_INPUT, "lights/input_shape");
    pbnds_proto_string(&node, NODE_INPUT, "lights/first");
    pbnds_proto_string(&node, NODE_INPUT, "lights/end");
    end_node(e, &node, "lights/count");
    node = begin_node("Concat", LIGHTS_SHAPE);
    pbnds_proto_string(&node, NODE_INPUT, "lights/count");
    pbnds_proto_string(&node, NODE_INPUT, "lights/ones");
    put_int(&node, "axis", 0);
    end_node(e, &node, LIGHTS_SHAPE);
    e->has_lights_shape = true;
}

/* Input i of CONCAT row r, one copy a light where the row is in the light scope. */
static struct name joined_input(struct exporter *e, int r, int i)
{
    const int in = e->table->layers[r].in[i];
    const struct name name = value_name(e, in);
    if (!pbnds_net_row_facts(e->net, r).light || pbnds_net_row_facts(e->net, in).light)
        return name;
    if (!e->has_lights_shape) put_lights_shape(e);
    struct name wide;
    (void)snprintf(wide.text, sizeof wide.text, "/%.96s/in%d", e->table->layers[r].name,
                   i);
    struct pbnds_proto node = begin_node("Expand", wide.text);
    pbnds_proto_string(&node, NODE_INPUT, name.text);
    pbnds_proto_string(&node, NODE_INPUT, LIGHTS_SHAPE);
    end_node(e, &node, wide.text);
    return wide;
}

static void put_parameter_inputs(struct pbnds_proto *node,
                                 const struct pbnds_layer *layer)
{
    static const char *const KINDS[2] = {"weight", "bias"};
    for (int k = 0; k < 2; ++k) {
        struct name name;
        (void)snprintf(name.text, sizeof name.text, "%s.%s", layer->name, KINDS[k]);
        pbnds_proto_string(node, NODE_INPUT, name.text);
    }
}

/* The node of a row, without its output. */
static struct pbnds_proto row_node(struct exporter *e, int r)
{
    const struct pbnds_layer *layer = &e->table->layers[r];
    struct name in[2] = {{""}, {""}};
    for (int i = 0; i < 2 && layer->in[i] >= 0; ++i) {
        in[i] = layer->op == PBNDS_OP_CONCAT ? joined_input(e, r, i)
                                             : value_name(e, layer->in[i]);
    }
    static const char *const OPS[] = {
        [PBNDS_OP_CONV] = "Conv",     [PBNDS_OP_UP] = "ConvTranspose",
        [PBNDS_OP_ADD] = "Add",       [PBNDS_OP_SHUFFLE] = "DepthToSpace",
        [PBNDS_OP_CONCAT] = "Concat", [PBNDS_OP_POOL] = "AveragePool",
    };
    struct pbnds_proto node = begin_node(OPS[layer->op], layer->name);
    pbnds_proto_string(&node, NODE_INPUT, in[0].text);
    if (in[1].text[0]) pbnds_proto_string(&node, NODE_INPUT, in[1].text);
    switch (layer->op) {
    case PBNDS_OP_CONV: {
        /* top, left, bottom, right: a 3x3 window of stride 2 begins before the image and
         * ends in it, since sizes are even */
        const int before = layer->kernel == 3 ? 1 : 0;
        const int behind = layer->stride == 1 ? before : 0;
        put_parameter_inputs(&node, layer);
        put_windows(&node, layer->kernel, layer->stride);
        put_ints(&node, "pads", 4, (const int[]){before, before, behind, behind});
        break;
    }
    case PBNDS_OP_UP:
        put_parameter_inputs(&node, layer);
        put_windows(&node, 2, 2);
        break;
    case PBNDS_OP_POOL:
        put_windows(&node, 2, 2);
        break;
    case PBNDS_OP_CONCAT:
        put_int(&node, "axis", 1);
        break;
    case PBNDS_OP_SHUFFLE:
        put_int(&node, "blocksize", 2);
        put_string(&node, "mode", "CRD");
        break;
    case PBNDS_OP_ADD:
    case PBNDS_OP_VIEW_INPUT:
    case PBNDS_OP_LIGHT_INPUT:
    case PBNDS_OP_DROPOUT:
        break;
    }
    return node;
}

static void put_row(struct exporter *e, int r)
{
    const struct pbnds_layer *layer = &e->table->layers[r];
    if (layer->op == PBNDS_OP_VIEW_INPUT || layer->op == PBNDS_OP_LIGHT_INPUT ||
        layer->op == PBNDS_OP_DROPOUT) {
        return;
    }
    const struct name value = value_name(e, r);
    struct pbnds_proto node = row_node(e, r);
    if (layer->act != PBNDS_ACT_RELU) {
        end_node(e, &node, value.text);
        return;
    }
    struct name before;
    (void)snprintf(before.text, sizeof before.text, "%.100s/linear", value.text);
    end_node(e, &node, before.text);
    node = begin_node("Relu", before.text);
    pbnds_proto_string(&node, NODE_INPUT, before.text);
    end_node(e, &node, value.text);
}

/* ---- ends ---- */

/* A dimension, by value or (0) by name. */
static void put_dimension(struct pbnds_proto *shape, int value, const char *name)
{
    enum { SHAPE_DIM = 1, DIM_VALUE = 1, DIM_PARAM = 2 };
    struct pbnds_proto dim = {0};
    if (value > 0) {
        pbnds_proto_int(&dim, DIM_VALUE, value);
    } else {
        pbnds_proto_string(&dim, DIM_PARAM, name);
    }
    pbnds_proto_message(shape, SHAPE_DIM, &dim);
}

static void put_side(struct pbnds_proto *shape, const char *name, int level)
{
    char text[32];
    if (level == 0) {
        (void)snprintf(text, sizeof text, "%s", name);
    } else {
        (void)snprintf(text, sizeof text, "%s/%d", name, 1 << level);
    }
    put_dimension(shape, 0, text);
}

/* An input or output of the graph that carries row r. */
static void put_end(struct exporter *e, int field, const char *name, int r,
                    const char *about)
{
    enum { INFO_NAME = 1, INFO_TYPE = 2, INFO_DOC = 3 };
    enum { TYPE_TENSOR = 1, TENSOR_ELEMENT = 1, TENSOR_SHAPE = 2 };
    const struct pbnds_row_facts facts = pbnds_net_row_facts(e->net, r);
    struct pbnds_proto shape = {0}, tensor = {0}, type = {0}, info = {0};
    put_dimension(&shape, facts.light ? 0 : 1, "N");
    put_dimension(&shape, facts.channels, NULL);
    put_side(&shape, "h", facts.level);
    put_side(&shape, "w", facts.level);
    pbnds_proto_int(&tensor, TENSOR_ELEMENT, TYPE_FLOAT);
    pbnds_proto_message(&tensor, TENSOR_SHAPE, &shape);
    pbnds_proto_message(&type, TYPE_TENSOR, &tensor);
    pbnds_proto_string(&info, INFO_NAME, name);
    pbnds_proto_message(&info, INFO_TYPE, &type);
    pbnds_proto_string(&info, INFO_DOC, about);
    pbnds_proto_message(&e->graph, field, &info);
}

static void put_output(struct exporter *e, const char *name, int r, const char *about)
{
    if (r < 0) return;
    const struct name value = value_name(e, r);
    struct pbnds_proto node = begin_node("Identity", name);
    pbnds_proto_string(&node, NODE_INPUT, value.text);
    end_node(e, &node, name);
    put_end(e, GRAPH_OUTPUT, name, r, about);
}

static void put_graph(struct exporter *e, const struct pbnds_model *model)
{
    pbnds_proto_string(&e->graph, GRAPH_NAME, model->name);
    put_parameters(e);
    for (int r = 0; r < e->table->layer_count; ++r) {
        const enum pbnds_op op = e->table->layers[r].op;
        if (!pbnds_net_row_facts(e->net, r).used) continue;
        put_row(e, r);
        if (op == PBNDS_OP_VIEW_INPUT)
            put_end(e, GRAPH_INPUT, VIEW_INPUT, r, "the G-buffer's features, NCHW");
        if (op == PBNDS_OP_LIGHT_INPUT)
            put_end(e, GRAPH_INPUT, LIGHT_INPUT, r, "one light's features each, NCHW");
    }
    put_output(e, LIGHT_OUTPUT, e->table->light_output, model->light_output_about);
    put_output(e, VIEW_OUTPUT, e->table->view_output, model->view_output_about);
}

static void put_metadata(struct pbnds_proto *model, const char *key, const char *value)
{
    enum { ENTRY_KEY = 1, ENTRY_VALUE = 2 };
    struct pbnds_proto entry = {0};
    pbnds_proto_string(&entry, ENTRY_KEY, key);
    pbnds_proto_string(&entry, ENTRY_VALUE, value);
    pbnds_proto_message(model, MODEL_METADATA, &entry);
}

enum pbnds_status pbnds_onnx_write(const char *path, const struct pbnds_model *model,
                                   const struct pbnds_net *net,
                                   const struct pbnds_metadata *metadata, int count,
                                   struct pbnds_error *error)
{
    enum { OPSET_VERSION = 2 };
    struct exporter e = {.table = &model->table, .net = net};
    struct pbnds_proto out = {0}, opset = {0};
    char about[160];
    (void)snprintf(about, sizeof about,
                   "%s; NCHW; h and w are multiples of %d (repeat the border)",
                   model->about ? model->about : model->name,
                   1 << pbnds_net_deepest_level(net));
    put_graph(&e, model);
    pbnds_proto_int(&out, MODEL_IR, IR_VERSION);
    pbnds_proto_string(&out, MODEL_PRODUCER, "pbnds");
    pbnds_proto_string(&out, MODEL_PRODUCER_VERSION, PBNDS_VERSION);
    pbnds_proto_int(&out, MODEL_VERSION, model->version);
    pbnds_proto_string(&out, MODEL_DOC, about);
    pbnds_proto_int(&opset, OPSET_VERSION, OPSET);
    pbnds_proto_message(&out, MODEL_OPSET, &opset);
    for (int i = 0; i < count; ++i)
        put_metadata(&out, metadata[i].key, metadata[i].value);
    pbnds_proto_message(&out, MODEL_GRAPH, &e.graph);
    enum pbnds_status status =
        out.failed
            ? pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for the model", path)
            : pbnds_file_write(path, out.data, out.size, error);
    pbnds_proto_free(&out);
    return status;
}
