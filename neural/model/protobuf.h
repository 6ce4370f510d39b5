/**
 * @file protobuf.h
 * Writes messages in protobuf's wire format (https://protobuf.dev/programming-guides/encoding):
 * a message is a sequence of fields, each a key (field number, wire type) and a varint
 * or a length with that many bytes. As much of it as onnx.c needs.
 */
#ifndef PBNDS_NEURAL_MODEL_PROTOBUF_H
#define PBNDS_NEURAL_MODEL_PROTOBUF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A message being written; zero to start with. Without memory, or beyond the 2 GiB that
 * readers take, `failed` is set, and what follows is dropped. */
struct pbnds_proto {
    uint8_t *data; /**< owned */
    size_t size, capacity;
    bool failed;
};

#ifdef __cplusplus
extern "C" {
#endif

/** int32, int64, enum. */
void pbnds_proto_int(struct pbnds_proto *message, int field, int64_t value);
void pbnds_proto_bytes(struct pbnds_proto *message, int field, const void *bytes,
                       size_t size);
/** NULL: the field is left out. */
void pbnds_proto_string(struct pbnds_proto *message, int field, const char *text);
/** Takes over what `child` holds; it is empty afterwards. */
void pbnds_proto_message(struct pbnds_proto *message, int field,
                         struct pbnds_proto *child);
void pbnds_proto_free(struct pbnds_proto *message);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_MODEL_PROTOBUF_H */
