// Tokens that outlive the program, so that pages find the studio again after a restart.
#pragma once

#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::studio {

struct KeptTokens {
  std::string operator_token, viewer_token;
};

/// Where they are kept: $XDG_RUNTIME_DIR, else $XDG_STATE_HOME, else ~/.local/state. Paths that are
/// not absolute do not count. Empty: none of them is set.
std::string kept_tokens_base();

/// The tokens of a server at `name` ("127.0.0.1_8642"), from `base`/cogrsim/studio: those that
/// keep_tokens() or this function left there in the last 24 hours, else new ones, which are left
/// there. To be called by the process that holds the port: that keeps others away from the file.
///
/// The folders are made with mode 0700 and the file with 0600. A file is believed only if it is this
/// user's, no one else may read or write it, and it is a plain file under one name; any other, and
/// one with another content, is replaced. Errors: a folder is another user's, leads elsewhere or
/// cannot be written to.
Result<KeptTokens> kept_tokens(const std::string& base, const std::string& name);

/// The 24 hours start again: for the end of a server.
void keep_tokens(const std::string& base, const std::string& name) noexcept;

/// The next kept_tokens() makes new ones. Errors: as above.
Result<> forget_tokens(const std::string& base, const std::string& name);

}  // namespace cogrsim::studio
