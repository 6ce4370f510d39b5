#include "neural/model/protobuf.h"

#include <stdlib.h>
#include <string.h>

enum { WIRE_VARINT = 0, WIRE_LENGTH = 2, VARINT_MAX = 10 };

static const size_t MESSAGE_MAX = 0x7fffffff; /* sizes are int32 in most readers */

/* Room for `more` bytes behind the message, or NULL. */
static uint8_t *extend(struct pbnds_proto *m, size_t more)
{
    if (m->failed || more > MESSAGE_MAX - m->size) {
        m->failed = true;
        return NULL;
    }
    if (more > m->capacity - m->size) {
        const size_t wanted = 2 * m->capacity + more + 64;
        uint8_t *data = realloc(m->data, wanted);
        if (!data) {
            m->failed = true;
            return NULL;
        }
        m->data = data;
        m->capacity = wanted;
    }
    uint8_t *at = m->data + m->size;
    m->size += more;
    return at;
}

/* Seven bits a byte, the lowest first; the eighth says that more follow. */
static void put_varint(struct pbnds_proto *m, uint64_t value)
{
    uint8_t bytes[VARINT_MAX];
    size_t n = 0;
    do {
        const uint64_t rest = value >> 7;
        bytes[n++] = (uint8_t)((value & 0x7f) | (rest ? 0x80 : 0));
        value = rest;
    } while (value);
    uint8_t *at = extend(m, n);
    if (at) memcpy(at, bytes, n);
}

static void put_key(struct pbnds_proto *m, int field, unsigned wire)
{
    put_varint(m, (uint64_t)field << 3 | wire);
}

void pbnds_proto_int(struct pbnds_proto *message, int field, int64_t value)
{
    put_key(message, field, WIRE_VARINT);
    put_varint(message, (uint64_t)value);
}

void pbnds_proto_bytes(struct pbnds_proto *message, int field, const void *bytes,
                       size_t size)
{
    put_key(message, field, WIRE_LENGTH);
    put_varint(message, size);
    uint8_t *at = extend(message, size);
    if (at && size > 0) memcpy(at, bytes, size);
}

void pbnds_proto_string(struct pbnds_proto *message, int field, const char *text)
{
    if (text) pbnds_proto_bytes(message, field, text, strlen(text));
}

void pbnds_proto_message(struct pbnds_proto *message, int field,
                         struct pbnds_proto *child)
{
    if (child->failed) message->failed = true;
    pbnds_proto_bytes(message, field, child->data, child->size);
    pbnds_proto_free(child);
}

void pbnds_proto_free(struct pbnds_proto *message)
{
    free(message->data);
    *message = (struct pbnds_proto){0};
}
