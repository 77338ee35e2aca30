#include "base/log.hpp"

#include <atomic>
#include <cstdio>

namespace raig::log {

namespace {
std::atomic<bool> isQuiet = false;
}

void setQuiet(bool quiet) {
    isQuiet = quiet;
}
bool quiet() {
    return isQuiet;
}

void noteText(const std::string& text) {
    if (!isQuiet) std::fprintf(stderr, "raig: %s\n", text.c_str());
}

void warnText(const std::string& text) {
    std::fprintf(stderr, "raig: warning: %s\n", text.c_str());
}

}  // namespace raig::log
