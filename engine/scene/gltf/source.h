/**
 * @file source.h
 * The bytes of a glTF file: container, JSON text, and the payloads that its URIs and
 * its BIN chunk hold. Private to the loader.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_SOURCE_H
#define PBNDS_ENGINE_SCENE_GLTF_SOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"
#include "engine/scene/gltf.h"

/** Largest single file, where the options say nothing. */
#define PBNDS_GLTF_MAX_FILE ((uint64_t)2 << 30)
/** What the parsed document may take where the options give no max_geometry. */
#define PBNDS_GLTF_MAX_STRUCTURE ((uint64_t)4 << 30)

/** What a buffer or an image refers to. */
struct pbnds_gltf_payload {
    char *uri;            /**< JSON-decoded, owned; NULL: none                       */
    uint64_t byte_length; /**< of a buffer; as declared                              */
    const uint8_t *data;  /**< after pbnds_gltf_resolve(); at least `size` bytes     */
    size_t size;
    uint8_t *owned; /**< data where it is not the container's                        */
};

struct pbnds_gltf_source {
    const char *name; /**< for messages, borrowed                                  */
    char *folder;     /**< URIs are looked for below; NULL: no file may be opened  */
    bool external;    /**< files outside of the folder may be opened               */
    size_t max_file;  /**< bytes                                                   */
    uint64_t max_structure; /**< bytes of the parsed document, as estimated          */
    char *json; /**< owned, edited by pbnds_gltf_scan()                      */
    size_t json_size;
    const uint8_t *bin; /**< BIN chunk, borrowed from the container; NULL: none      */
    size_t bin_size;
    struct pbnds_gltf_payload *buffers, *images;
    size_t buffer_count, image_count;
    bool odd_list; /**< a list of the document is something else, after the scan */
};

/** Splits a container (.glb or .gltf, by its first bytes). `bytes` must outlive the
 *  source. Errors: FORMAT, UNSUPPORTED (glTF 1.0), MEMORY. */
enum pbnds_status pbnds_gltf_source_open(struct pbnds_gltf_source *source,
                                         const uint8_t *bytes, size_t size,
                                         const char *name, const char *folder,
                                         const struct pbnds_gltf_options *options,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** The limit of the options, or PBNDS_GLTF_MAX_FILE. */
size_t pbnds_gltf_max_file(const struct pbnds_gltf_options *options);
void pbnds_gltf_source_free(struct pbnds_gltf_source *source);

/** Makes the JSON safe for a parser that trusts it: bounds the nesting, refuses numbers
 *  that are no index where an index stands, and moves every URI of a buffer or an image
 *  and every buffer's byteLength out of the text into `source`. Errors: FORMAT, MEMORY.
 */
enum pbnds_status pbnds_gltf_scan(struct pbnds_gltf_source *source,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

/** Fetches a payload: BIN chunk, data: URI or file below the folder. `what` and `index`
 *  name it in messages ("buffer", 0). Errors: IO, FORMAT, MEMORY. */
enum pbnds_status pbnds_gltf_resolve(const struct pbnds_gltf_source *source,
                                     struct pbnds_gltf_payload *payload,
                                     const char *what, size_t index,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_ENGINE_SCENE_GLTF_SOURCE_H */
