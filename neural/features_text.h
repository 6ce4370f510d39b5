/**
 * @file features_text.h
 * The feature tables in words, for the metadata of weights files and of exported models:
 * what a network's inputs are can be read from the file alone.
 */
#ifndef PBNDS_NEURAL_FEATURES_TEXT_H
#define PBNDS_NEURAL_FEATURES_TEXT_H

#include "neural/features.h"
#include "neural/model/model.h"

/** Texts, owned; free with pbnds_features_text_free(). */
struct pbnds_features_text {
    /** Rows in order, each as the formula of its value: "albedo.R; (log_depth - 1) * 2;
     *  log1p(max(L.R n.l, 0))". No name has a semicolon in it. */
    char *view, *light;
    /** "none", or how many bands and in which order. */
    char *encoding;
    /** The channels of the encoded inputs in order: "albedo.R; ...; sin(1 albedo.R); ..." */
    char *view_channels, *light_channels;
    /** A line a row: "albedo.R: base colour ...". */
    char *about;
};

#ifdef __cplusplus
extern "C" {
#endif

/** The table that a model was made for; NULL: none. */
const struct pbnds_feature_table *pbnds_features_of(const struct pbnds_model *model);
/** Errors: MEMORY. */
enum pbnds_status pbnds_features_text(const struct pbnds_feature_table *table,
                                      struct pbnds_features_text *text,
                                      struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_features_text_free(struct pbnds_features_text *text);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_FEATURES_TEXT_H */
