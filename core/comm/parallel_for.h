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

/// Calls body(i) for all i in [first, last), on the threads of the calling thread's task arena. Returns when
/// all calls have ended. An exception in one ends the loop and is thrown here. The thread sanitizer cannot
/// see how oneTBB's threads hand work to each other, so with it two plain threads run the loop: it then
/// reports races between bodies only.
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

/// The same for short bodies. It runs them in blocks of 8192 and reports each finished block to `advance`.
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

/// std::sort on the threads of the calling thread's task arena; with the thread sanitizer, on the calling
/// thread alone.
template <class Iterator>
void parallelSort(Iterator begin, Iterator end) {
#ifdef __SANITIZE_THREAD__
  std::sort(begin, end);
#else
  tbb::parallel_sort(begin, end);
#endif
}

}  // namespace gxy
