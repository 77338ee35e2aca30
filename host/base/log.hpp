/// What the program tells a person while it works: one line each, on standard error, silenced by --quiet.
#pragma once

#include <fmt/format.h>

#include <string>

namespace raig::log {

/// Silences note() (errors and warnings still appear).
void setQuiet(bool quiet);
bool quiet();

/// Prints "raig: TEXT" on standard error, "raig: warning: TEXT", or "raig: KIND: TEXT": one line, whatever names and bytes of
/// the user's ended up in the text; control characters become blanks.
void noteText(const std::string& text);
void warnText(const std::string& text);
void errorText(const std::string& kind, const std::string& text);

template <class... Args>
void note(fmt::format_string<Args...> format, Args&&... args) {
    noteText(fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
    warnText(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace raig::log
