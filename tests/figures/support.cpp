#include "support.h"

#include <cstdlib>

#include <algorithm>
#include <fstream>
#include <sstream>

#include <catch2/catch.hpp>

namespace fs = std::filesystem;

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> drawn(const cogrsim::figures::Figure& figure, const std::string& path) {
  const auto files = cogrsim::figures::draw(figure, path);
  INFO(path << ": " << (files ? "" : files.error().text()));
  REQUIRE(files);
  return *files;
}
