/// Command lines as text, for a person to paste.
#pragma once

#include <string>

namespace raig {

/// As a shell takes it for one word.
std::string quoted(const std::string& text);

}  // namespace raig
