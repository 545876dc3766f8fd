// SPDX-License-Identifier: Apache-2.0
// The process that starts the workers and reads what they measure.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "core/comm/error.h"
#include "tools/gxybench/job.h"

namespace gxy::bench {
namespace {

/// Runs a program to its end, and calls `onLine` for each line of its standard output. The program ends with
/// this process.
int run(const std::vector<std::string>& command, const std::function<void(const std::string&)>& onLine) {
  std::vector<char*> arguments;
  for (const std::string& a : command) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  int ends[2];
  if (::pipe(ends) != 0) throw Error("no pipe could be made to start " + command[0]);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw Error(command[0] + ": no process could be made");
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]), ::close(ends[1]);
    ::execvp(arguments[0], arguments.data());
    std::perror(arguments[0]);
    ::_exit(127);
  }
  ::close(ends[1]);
  // The child ends with this function, however that ends.
  const auto reap = [child](const int* input) {
    ::close(*input);
    ::kill(child, SIGTERM);
    ::waitpid(child, nullptr, 0);
  };
  std::unique_ptr<const int, decltype(reap)> guard(&ends[0], reap);
  const std::unique_ptr<FILE, int (*)(FILE*)> in(::fdopen(::dup(ends[0]), "r"), ::fclose);
  std::string line;
  for (int c; (c = std::fgetc(in.get())) != EOF;) {
    if (c != '\n') {
      line += char(c);
      continue;
    }
    onLine(line);
    line.clear();
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  guard.release();
  ::close(ends[0]);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

template <class Values>
Values take(const std::string& path, size_t count) {
  using T = typename Values::value_type;
  Values values(count);
  {
    std::ifstream in(path, std::ios::binary);
    in.read(reinterpret_cast<char*>(values.data()), std::streamsize(count * sizeof(T)));
    if (!in) throw Error(path + ": expected a picture of " + std::to_string(count * sizeof(T)) + " bytes");
  }
  std::filesystem::remove(path);
  return values;
}

}  // namespace

void measure(const Job& job, int ranks, const std::string& launcher, const Measured& measured) {
  const std::string file = job.pictures + "job.json";
  std::ofstream(file) << toJson(job).dump();
  std::vector<std::string> command;
  if (!launcher.empty()) {
    std::istringstream words(launcher + " " + std::to_string(ranks));
    for (std::string word; words >> word;) command.push_back(word);
  }
  command.push_back(std::filesystem::read_symlink("/proc/self/exe").string());
  command.insert(command.end(), {"work", file});

  const auto takeLine = [&](const std::string& line) {
    if (!line.starts_with(kLineMark)) {
      std::fprintf(stderr, "%s\n", line.c_str());
      return;
    }
    const nlohmann::json json = nlohmann::json::parse(line.substr(std::string(kLineMark).size()));
    const size_t i = json.at("setting index");
    Row row = rowOf(json.at("row"));
    const size_t pixels = size_t(row.width * row.height);
    const std::string name = pictureFile(job, i);
    Picture picture{int(row.width), int(row.height), take<LargeVector<float>>(name + ".raw", 4 * pixels),
                    take<std::vector<double>>(name + ".depth", pixels)};
    measured(i, std::move(row), std::move(picture));
  };
  const int status = run(command, takeLine);
  std::filesystem::remove(file);
  if (status != 0)
    throw Error("measuring on " + std::to_string(ranks) + " rank(s) failed with exit status " +
                std::to_string(status));
}

}  // namespace gxy::bench
