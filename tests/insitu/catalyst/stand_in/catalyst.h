/* SPDX-License-Identifier: Apache-2.0
 * A stand-in for Catalyst 2 and its Conduit, in our own words: names, arguments and numbers are those of the binary interface. A
 * program that is written with this header compiles with that of Catalyst, too. */
#ifndef CATALYST_STAND_IN_H
#define CATALYST_STAND_IN_H
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct conduit_node_impl conduit_node;
typedef int64_t conduit_index_t;

enum catalyst_status {
  catalyst_status_ok = 0,
  catalyst_status_error_no_implementation,
  catalyst_status_error_already_loaded,
  catalyst_status_error_not_found,
  catalyst_status_error_not_catalyst,
  catalyst_status_error_incomplete,
  catalyst_status_error_unsupported_version,
  catalyst_status_error_conduit_mismatch,
  stand_in_status_of_implementations = 100 /* Implementations have numbers of their own from here on. */
};
enum catalyst_status catalyst_initialize(const conduit_node* params);
enum catalyst_status catalyst_execute(const conduit_node* params);
enum catalyst_status catalyst_finalize(const conduit_node* params);
enum catalyst_status catalyst_about(conduit_node* params);
enum catalyst_status catalyst_results(conduit_node* params);

conduit_node* catalyst_conduit_node_create(void);
void catalyst_conduit_node_destroy(conduit_node* node);
void catalyst_conduit_node_set_path_char8_str(conduit_node* node, const char* path, const char* value);
void catalyst_conduit_node_set_path_int64(conduit_node* node, const char* path, int64_t value);
void catalyst_conduit_node_set_path_float64(conduit_node* node, const char* path, double value);
void catalyst_conduit_node_set_path_external_int32_ptr_detailed(conduit_node* node, const char* path,
                                                                int32_t* data, conduit_index_t count,
                                                                conduit_index_t offset,
                                                                conduit_index_t stride, conduit_index_t bytes,
                                                                conduit_index_t endianness);
void catalyst_conduit_node_set_path_external_float64_ptr_detailed(
    conduit_node* node, const char* path, double* data, conduit_index_t count, conduit_index_t offset,
    conduit_index_t stride, conduit_index_t bytes, conduit_index_t endianness);

/* Only here: values of any type id in the caller's memory; endianness 0 is that of the machine. */
void stand_in_set_external(conduit_node* node, const char* path, conduit_index_t type, void* data,
                           conduit_index_t count, conduit_index_t offset, conduit_index_t stride,
                           conduit_index_t endianness);
/* Only here: takes away what is at the path, which is there. */
void stand_in_remove(conduit_node* node, const char* path);
/* Only here: the text at the path, or NULL. */
const char* stand_in_text(conduit_node* node, const char* path);

#ifdef __cplusplus
}
#endif
#endif
