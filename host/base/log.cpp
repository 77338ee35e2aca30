#include "base/log.hpp"

#include <atomic>
#include <cstdio>

namespace raig::log {

namespace {

std::atomic<bool> isQuiet = false;

/// One line, whatever names of files may hold: terminals obey some characters.
void write(const char* before, std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    std::fprintf(stderr, "%s%s\n", before, text.c_str());
}

}  // namespace

void setQuiet(bool quiet) {
    isQuiet = quiet;
}
bool quiet() {
    return isQuiet;
}

void noteText(const std::string& text) {
    if (!isQuiet) write("raig: ", text);
}

void warnText(const std::string& text) {
    write("raig: warning: ", text);
}

}  // namespace raig::log
