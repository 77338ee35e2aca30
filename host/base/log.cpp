#include "base/log.hpp"

#include <atomic>
#include <cctype>
#include <cstdio>

namespace raig::log {

namespace {

std::atomic<bool> isQuiet = false;

void writeLine(std::string text) {
    for (char& c : text)
        if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
    std::fprintf(stderr, "raig: %s\n", text.c_str());
}

}  // namespace

void setQuiet(bool quiet) {
    isQuiet = quiet;
}
bool quiet() {
    return isQuiet;
}

void noteText(const std::string& text) {
    if (!isQuiet) writeLine(text);
}

void warnText(const std::string& text) {
    writeLine("warning: " + text);
}

void errorText(const std::string& kind, const std::string& text) {
    writeLine(kind + ": " + text);
}

}  // namespace raig::log
