// SPDX-License-Identifier: Apache-2.0
// The structure through which kernels see what is recorded where sampling rays meet surfaces, in one partition. A
// backend's host side fills it in. scene_view.h must come before.

struct SamplingView {
  int fields;
  PTR(VolumeView) field;
  PTR(int) isovalueOf;  // per operator and field: whether the operator's isosurfaces are of this field
  int gradient;         // whether gradients of the volumes that are met are recorded
  int conditions;
  PTR(int) conditionOperator;
  PTR(int) conditionField;
  PTR(real) conditionRange;  // two per condition, stored values
  PTR(int) hits;             // per operator: the number of hits with which a ray ends there
};
