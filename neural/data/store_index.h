/**
 * @file store_index.h
 * Where the members of a tar file are: its headers read once, each member then one read
 * at its offset. Reads ustar, pax (path, size) and GNU long names; POSIX.1-2017, pax,
 * "ustar Interchange Format". Nothing in a file is believed: checksums are verified, and
 * sizes against the length of the file.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_INDEX_H
#define PBNDS_NEURAL_DATA_STORE_INDEX_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

/** A regular file in a tar. Longer names are none of a data set: they are left out. */
struct pbnds_tar_member {
    char name[80];
    uint64_t header; /**< where its (first) header begins */
    uint64_t offset; /**< of its bytes                    */
    uint64_t size;
};

/** By name (strcmp), of the same name the earlier one first; owned. */
struct pbnds_tar_index {
    struct pbnds_tar_member *members;
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: IO, FORMAT (damaged, cut short), MEMORY. */
enum pbnds_status pbnds_tar_index_read(const char *path, struct pbnds_tar_index *index,
                                       struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_tar_index_free(struct pbnds_tar_index *index);
/** The first member of that name, or NULL. */
const struct pbnds_tar_member *pbnds_tar_find(const struct pbnds_tar_index *index,
                                              const char *name);
/** Members whose names begin with `KEY.`: the first's place in the index, and how many. */
int pbnds_tar_find_key(const struct pbnds_tar_index *index, const char *key,
                       int *count);

/** A member's bytes, malloc'd with one zero byte behind them. Errors: IO, MEMORY, FORMAT
 *  (the file is shorter now). */
enum pbnds_status pbnds_tar_read(const char *path,
                                 const struct pbnds_tar_member *member, uint8_t **bytes,
                                 size_t *size,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

/** Looks for the member `name` from the header at `hint` on, for as long as names begin
 *  with its key (up to the first dot), then in the whole file. Errors: those of the index;
 *  FORMAT where there is none. */
enum pbnds_status pbnds_tar_locate(const char *path, uint64_t hint, const char *name,
                                   struct pbnds_tar_member *member,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_INDEX_H */
