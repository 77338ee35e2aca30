/// A chart made by hand, for tests of its page.
#pragma once

#include "measure/chart_document.hpp"

namespace raig::test {

/// A name that would do harm if it were taken for markup.
inline constexpr const char* hostileName = "</script><img src=x onerror=alert(1)>";

/// Two scenes, one of that name, with pictures; three figures, with 5 panels, 120 points, some of which were left out or
/// have measures that are null or 0, two breaches and two things missing; a driver whose name is not UTF-8.
ChartDocument chartDocument();

}  // namespace raig::test
