// The page that holds a bundle.
#pragma once

#include <string>
#include <string_view>

namespace cogrsim::studio {

/// One page that needs no other file and sends no request: `data`, compressed, and the
/// viewer. Its scripts are known by their hashes; no other runs, and nothing is fetched.
std::string bundle_html(const std::string& title, std::string_view data);

/// Whether a file begins as those of bundle_html() do. False also if it cannot be read.
bool is_bundle(const std::string& path);

}  // namespace cogrsim::studio
