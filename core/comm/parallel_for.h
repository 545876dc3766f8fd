// SPDX-License-Identifier: Apache-2.0
// Loops and sorting over oneTBB threads.
#pragma once
#include <algorithm>
#include <atomic>

#include "core/comm/advance.h"
#ifdef __SANITIZE_THREAD__
#include <exception>
#include <mutex>
#include <thread>
#else
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#endif

namespace gxy {

/// body(i) for i in [first, last), on the threads of the calling thread's task arena; returns when all have ended. An
/// exception out of one ends the loop and arrives here. Under the thread sanitizer, which cannot see how oneTBB's
/// threads hand each other their work, two plain threads do it, so that races of bodies are found and none of oneTBB's.
template <class Index, class Body>
void parallelFor(Index first, Index last, const Body& body) {
#ifdef __SANITIZE_THREAD__
  std::atomic<Index> next{first};
  std::mutex mutex;
  std::exception_ptr error;
  const auto work = [&] {
    for (Index i = next++; i < last; i = next++) {
      try {
        body(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = last;
      }
    }
  };
  std::thread other(work);
  work();
  other.join();
  if (error) std::rethrow_exception(error);
#else
  tbb::parallel_for(first, last, body);
#endif
}

/// The same for short bodies, in blocks of which `advance` is told.
template <class Index, class Body>
void parallelFor(Index first, Index last, const Body& body, const Advance& advance) {
  constexpr Index kBlock = 8192;
  const Index blocks = (last - first + kBlock - 1) / kBlock;
  std::atomic<Index> done = 0;
  parallelFor(Index(0), blocks, [&](Index block) {
    const Index begin = first + block * kBlock;
    for (Index i = begin, end = std::min<Index>(last, begin + kBlock); i < end; i++) body(i);
    advance(double(++done) / double(blocks));
  });
}

/// std::sort, on the threads of the calling thread's task arena; under the thread sanitizer on its own.
template <class Iterator>
void parallelSort(Iterator begin, Iterator end) {
#ifdef __SANITIZE_THREAD__
  std::sort(begin, end);
#else
  tbb::parallel_sort(begin, end);
#endif
}

}  // namespace gxy
