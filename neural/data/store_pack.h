/**
 * @file store_pack.h
 * From a sample's folder to what the data set keeps of it.
 */
#ifndef PBNDS_NEURAL_DATA_STORE_PACK_H
#define PBNDS_NEURAL_DATA_STORE_PACK_H

#include <stdbool.h>

#include "neural/data/store_index.h"
#include "neural/data/store_tar.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Adds "files" to sample.json: bytes and xxh64 of every other file of the folder. */
enum pbnds_status pbnds_sample_seal(const char *folder,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Are the files what sample.json says of them? */
bool pbnds_sample_is_sound(const char *folder);
/** Adds a folder's files to a tar as NNNNNN.FILE, in the order of their names. */
enum pbnds_status pbnds_pack_folder(struct pbnds_tar_writer *writer, const char *folder,
                                    int index,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Adds the members of a sample of another tar; none where it is not in there. */
enum pbnds_status pbnds_pack_members(struct pbnds_tar_writer *writer, const char *tar,
                                     const struct pbnds_tar_index *members, int index,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_DATA_STORE_PACK_H */
