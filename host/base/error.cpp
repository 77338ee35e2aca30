#include "base/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace raig {

void checkFailed(const char* file, int line, const std::string& what) {
    std::fprintf(stderr, "raig: %s:%d: this should hold and does not: %s\n", file, line, what.c_str());
    std::abort();
}

}  // namespace raig
