// SPDX-License-Identifier: Apache-2.0
// Loops over oneTBB threads.
#pragma once
#include <tbb/parallel_for.h>

#include "thread_order.h"

namespace gxy {

/// body(i) for i in [first, last), on the threads of the calling thread's task arena; returns when all have ended. An
/// exception out of one ends the loop and arrives here.
template <class Index, class Body>
void parallelFor(Index first, Index last, const Body& body) {
  const ThreadOrder order(&body);
  order.handOver();
  tbb::parallel_for(first, last, [&](Index i) {
    order.begin();
    body(i);
    order.end();
  });
  order.takeBack();
}

}  // namespace gxy
