/// Results as JUnit's XML, which continuous integration shows as tests.
#pragma once

#include <string>
#include <vector>

namespace raig {

struct JUnitCase {
    std::string group;  ///< "stress.bvh"
    std::string name;
    double seconds = 0.0;
    std::string failure;  ///< why it failed; empty: it passed
};

/// One test suite. Whatever bytes are in the texts, the document is well formed.
std::string junitXml(const std::string& suite, const std::vector<JUnitCase>& cases);

/// The text as it may stand in XML and HTML, in attributes as well: control characters become spaces, and bytes that are not
/// UTF-8 question marks.
std::string escapedMarkup(const std::string& text);

}  // namespace raig
