// SPDX-License-Identifier: Apache-2.0
// Work that a stage can do in several dispatches, for devices that limit how long an invocation's loops run.
//
// Mesa's software device ends all loops of an invocation, without a word, when they have gone round 65535 times together; the next
// loop then goes round once. The host finds out whether a device does so and sets the constant LIMITED. On all other devices
// LIMITED is false, a slice is always the whole, and the compiler removes this file's code.
//
// On a limited device, a stage that may run too long works on a slice of its range. At its end it asks whether its loops were cut
// short. If so, it forgets what it has done, and does half of the slice when the host dispatches it again; if not, it goes on with
// the range behind the slice. Slices of t are cut like partitions, so that no result depends on where they are cut.

// The range [from, to) of a range that ends at `end`.
struct RaySlice {
  float from, to, end;
};

// Whether the step that this dispatch does is due for this invocation's ray. Once a ray has not ended a step, no ray begins the
// steps behind it before the host has dispatched that step again.
bool stepIsDue() {
  bool due = true;
  if (LIMITED) {
    bool cutBefore = counts[COUNT_CUT] > ~uint(push[PUSH_STEP]);
    due = !cutBefore && GIVEN(step) <= push[PUSH_STEP];
  }
  return due;
}

// The slice of [begin, end) that is due: the whole of it, unless an earlier dispatch was cut short.
RaySlice sliceOf(float begin, float end) {
  RaySlice slice = RaySlice(begin, end, end);
  if (LIMITED && GIVEN(step) == ~push[PUSH_STEP]) {
    slice.from = GIVEN(from);
    slice.to = min(GIVEN(to), end);
  }
  return slice;
}

// Whether an earlier dispatch has done what is in front of a slice of a range that begins at 0.
bool isResumed(RaySlice slice) { return LIMITED && slice.from > 0.0; }

// Whether a child of a node of the hierarchy may have leaves of the nodes [begin, end). A leaf counts as part of its node. A child
// that is a node has below it the nodes from its own number to that of the next child among `behind` that is a node.
bool mayHoldOfSlice(uint child, uvec3 behind, uint node, uint begin, uint end) {
  bool may = !LIMITED || (node >= begin && node < end);
  if (LIMITED && (child & NODE_LEAF) == 0u) {
    uint next = min(min(behind.x, behind.y), behind.z);  // words of leaves are larger than those of nodes
    may = child < end && next > begin;
  }
  return may;
}

// Whether the device has ended this invocation's loops: then this loop, too, goes round once only.
bool wasCutShort() {
  int rounds = 0;
  for (int i = 0; i < push[PUSH_ROUNDS]; i++) rounds += push[PUSH_ONE];
  return rounds < push[PUSH_ROUNDS];
}

// A stage without slices calls this at its end. If it was cut short, its work is lost, and the host reports that.
void endStage() {
  if (LIMITED && wasCutShort()) atomicAdd(counts[COUNT_STUCK], 1u);
}

// A stage with slices calls this at its end, in all invocations alike. Returns whether the slice was done, so that its results
// hold. `over` says that nothing is left to do behind it. If it was cut short, the slice ends at `middle` next time, which
// must lie between its ends unless it cannot be halved; else the next slice ends at `next`.
bool endSlice(RaySlice slice, float middle, float next, bool over) {
  if (!LIMITED) return true;
  bool cut = wasCutShort();
  bool ended = !cut && (over || !(slice.to < slice.end));
  if (cut && !(middle > slice.from && middle < slice.to)) {
    atomicAdd(counts[COUNT_STUCK], 1u);
    ended = true;
  }
  RAY(step) = ended ? push[PUSH_STEP] + 1 : ~push[PUSH_STEP];
  if (!ended) {
    RAY(from) = cut ? slice.from : slice.to;
    RAY(to) = cut ? middle : next;
    atomicMax(counts[COUNT_CUT], ~uint(push[PUSH_STEP]));
  }
  return !cut;
}
bool endSlice(RaySlice slice, bool over) {
  return endSlice(slice, 0.5 * (slice.from + slice.to), slice.to + (slice.to - slice.from), over);
}
