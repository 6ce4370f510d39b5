/**
 * @file error.h
 * The error contract of the whole library.
 *
 * A call that can fail returns enum pbnds_status and fills a caller-owned
 * struct pbnds_error with one sentence: the file, the fault, what to do.
 * Nothing is printed, nothing exits; on failure every output is left unset or
 * empty, and no file is left under its final name.
 */
#ifndef PBNDS_ENGINE_CORE_ERROR_H
#define PBNDS_ENGINE_CORE_ERROR_H

/** What a call that can fail returns. Zero is success; values are stable. */
enum pbnds_status {
    PBNDS_OK = 0,
    PBNDS_ERROR_ARGUMENT,    /**< an argument is outside its documented range (exit 2) */
    PBNDS_ERROR_IO,          /**< a file could not be opened, read or written (exit 1) */
    PBNDS_ERROR_FORMAT,      /**< the file was read, its content is not valid (exit 3) */
    PBNDS_ERROR_UNSUPPORTED, /**< valid, but a feature this version lacks (exit 4) */
    PBNDS_ERROR_MEMORY,      /**< an allocation failed or a budget is exceeded (exit 1) */
    PBNDS_ERROR_BACKEND,     /**< Embree or oneDNN refused; the message says why (exit 1) */
    PBNDS_ERROR_INTERRUPTED, /**< the user asked to stop (exit 1) */
};

/** Room for one sentence about the first failure. Owned by the caller. */
struct pbnds_error {
    char message[1024]; /**< UTF-8, always terminated, empty on success */
};

#if defined(__GNUC__)
#define PBNDS_NODISCARD         __attribute__((warn_unused_result))
#define PBNDS_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define PBNDS_NODISCARD
#define PBNDS_PRINTF(fmt, args)
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Writes the sentence into `error` (which may be NULL) and returns `status`. What the
 *  sentence quotes of a file cannot break its line or reach the terminal as a command:
 *  it goes through pbnds_plain_text(). */
enum pbnds_status pbnds_fail(struct pbnds_error *error, enum pbnds_status status,
                             const char *format, ...) PBNDS_PRINTF(3, 4);

/** Replaces every control character of UTF-8 text by a question mark. */
void pbnds_plain_text(char *text);

#ifdef __cplusplus
}
#endif

/** Returns from the calling function when `call` fails. No cleanup: use it
 *  where nothing is held yet, `goto done` everywhere else. */
#define PBNDS_TRY(call)                                                                \
    do {                                                                               \
        const enum pbnds_status try_status_ = (call);                                  \
        if (try_status_ != PBNDS_OK) return try_status_;                               \
    } while (0)

#endif /* PBNDS_ENGINE_CORE_ERROR_H */
