// SPDX-License-Identifier: Apache-2.0
// Prints the lines of a client.
#pragma once
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace gxy {

/// Prints lines in the order in which they are given, on a thread of its own, so that the thread that reads
/// from the server never waits for a slow pipe or a stopped terminal. Control characters are replaced
/// (protocol::printable()). Thread safe.
class Output {
 public:
  Output();
  /// Prints all waiting lines.
  ~Output();
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void line(const std::string& text) { add(Kind::Line, text); }    ///< prints to standard output
  void error(const std::string& text) { add(Kind::Error, text); }  ///< prints to standard error
  /// Shows progress on standard error, if that is a terminal, until something else is printed.
  void progress(const std::string& text);
  /// Waits until everything is printed, and removes progress.
  void flush();

  /// Waits until everything is printed. From then on until release(), only printHeld() prints, because a line
  /// is being edited.
  void hold();
  void release();
  /// If lines wait, calls `before` and prints them on this thread. Returns whether lines waited.
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
  bool progressShown_ = false;  ///< used by the thread that prints
  std::thread thread_;
};

}  // namespace gxy
