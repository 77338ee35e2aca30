/// What can be known of the files that a command is to write before it begins: nobody should wait for a picture that has no
/// place.
#pragma once

#include "app/options.hpp"

namespace raig {

/// Throws usageError where a file would replace one that is to be read, or another one to be written; inputError where there
/// is no folder for it, or none that may be written to.
void checkWrittenFiles(const Options& options);

}  // namespace raig
