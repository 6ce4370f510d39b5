/**
 * @file jail.h
 * Which file may be opened because a scene file names it: a regular file below one
 * folder. Private to the loader.
 */
#ifndef PBNDS_ENGINE_SCENE_GLTF_JAIL_H
#define PBNDS_ENGINE_SCENE_GLTF_JAIL_H

#include <stdbool.h>
#include <stddef.h>

enum pbnds_jail {
    PBNDS_JAIL_OPEN,    /**< *fd is open                                            */
    PBNDS_JAIL_SCHEME,  /**< file:, http:, C: ...; or no path at all                */
    PBNDS_JAIL_OUTSIDE, /**< absolute, through .., or by a link that leads out      */
    PBNDS_JAIL_MISSING, /**< nothing there, or not allowed to be read               */
    PBNDS_JAIL_SPECIAL, /**< a folder, pipe, device or socket                       */
};

/**
 * Opens `path` (percent-decoded, `length` bytes) for reading, relative to `folder`.
 * Links may be followed as long as they stay below the folder. The name is resolved
 * once, and then walked folder by folder without following any link: who swaps a link in
 * between makes it fail, and gets nothing from outside. A pipe or a device is never
 * opened: that alone can block or act.
 *
 * With `external` the path may be absolute and lead anywhere; schemes and special files
 * stay closed. A hard link is a file of the folder: nothing tells it from one.
 */
enum pbnds_jail pbnds_jail_open(const char *folder, const char *path, size_t length,
                                bool external, int *fd);

#endif /* PBNDS_ENGINE_SCENE_GLTF_JAIL_H */
