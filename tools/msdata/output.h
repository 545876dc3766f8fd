// SPDX-License-Identifier: Apache-2.0
// Where a client's lines are printed.
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace gxy {

/// Prints lines in the order in which they are given, on a thread of its own: who gives them, as the thread that reads
/// from a server, never waits for a slow pipe or a stopped terminal. What a terminal could obey in them is replaced. Thread
/// safe.
class Output {
 public:
  Output();
  /// Prints what waits.
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void line(const std::string& text) { add(Kind::Line, text); }    ///< to standard output
  void error(const std::string& text) { add(Kind::Error, text); }  ///< to standard error
  /// How far work is, on standard error if that is a terminal, until something else is printed.
  void progress(const std::string& text);
  /// Waits until all is printed; no progress is shown afterwards.
  void flush();

  /// From here, with all printed, until release() nothing is printed but by printHeld(): a line is being edited.
  void hold();
  void release();
  /// Prints what waits, if something does, on this thread, `before` it; whether something did.
  bool printHeld(const std::function<void()>& before);

 private:
  enum class Kind { Line, Error, Progress };
  struct Item {
    Kind kind;
    std::string text;
  };

  void add(Kind kind, const std::string& text);
  void run();
  void printWaiting(std::unique_lock<std::mutex>& lock);
  void print(const Item& item);
  void clearProgress();

  const bool terminal_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> waiting_;
  bool printing_ = false, held_ = false, ending_ = false;
  bool progressShown_ = false;  ///< of whoever prints
  std::thread thread_;
};

}  // namespace gxy
