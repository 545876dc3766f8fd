// SPDX-License-Identifier: Apache-2.0
// insitu_benchmark PART ARGUMENTS...: what insitu_bench.py starts.
#include <cstdlib>
#include <exception>
#include <iostream>
#include <vector>

#include "core/comm/error.h"
#include "tests/insitu/bench/parts.h"

namespace gxy::bench {

nlohmann::json To::options() const {
  if (address.empty()) return {{"to", "off"}};
  return {{"to", address}, {"token-file", tokenFile}, {"reconnect", 0.1}};
}

namespace {

void run(const std::string& part, const std::vector<std::string>& a) {
  const auto number = [&](size_t i) { return std::stoi(a.at(i)); };
  nlohmann::json result;
  if (part == "publish")
    result = publishes({a.at(0), a.at(1)}, number(2));
  else if (part == "copy")
    result = copies({number(0), number(1), number(2)}, number(3));
  else if (part == "raw")
    result = rawTcp(number(0), number(1), std::stoull(a.at(2)), number(3));
  else if (part == "carry")
    result = carries(std::stoull(a.at(0)), number(1));
  else if (part == "rank")
    return simulate({a.at(0), a.at(1)},
                    {number(2), number(3), number(4), number(5), number(6), std::stod(a.at(7))});
  else
    throw Error("part " + part +
                ", expected publish, copy, raw, carry or rank, as insitu_bench.py starts them");
  std::cout << result.dump() << std::endl;
}

}  // namespace
}  // namespace gxy::bench

int main(int argc, char** argv) {
  try {
    if (argc < 2) throw gxy::Error("no part, expected one; insitu_bench.py starts this program");
    gxy::bench::run(argv[1], {argv + 2, argv + argc});
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "insitu_benchmark: error: " << e.what() << '\n';
    return 1;
  }
}
