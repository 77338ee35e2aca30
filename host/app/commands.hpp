/// The program's commands, one file each. They return the exit code (done, or fellShort where they compare) and throw Error
/// for all else. Only results go to standard output, through stdio; main flushes it and reports what could not be written.
#pragma once

#include "app/options.hpp"

namespace raig {

int render(const Options& options);
int trace(const Options& options);
int compare(const Options& options);
int bench(const Options& options);
int chart(const Options& options);
int stress(const Options& options);
int info(const Options& options);
int devices(const Options& options);

}  // namespace raig
