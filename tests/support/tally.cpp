#include "support/tally.hpp"

#include <fmt/format.h>

#include <ostream>

namespace raig::test {

using hard::Verdict;

size_t Tally::of(Verdict verdict) const {
    const auto found = counts.find(verdict);
    return found == counts.end() ? 0 : found->second;
}

std::ostream& operator<<(std::ostream& out, const Tally& t) {
    return out << fmt::format(
               "{} rays, {} hits: {} the same, {} ties, {} open, {} missed, {} phantoms, {} wrong, {} unsound{}", t.rays,
               t.hits, t.of(Verdict::same), t.of(Verdict::tie), t.open, t.of(Verdict::missed), t.of(Verdict::phantom),
               t.of(Verdict::wrong), t.unsound, t.first.empty() ? "" : "; " + t.first);
}

Tally judge(const hard::Oracle& oracle, std::span<const Ray> rays, std::span<const Hit> hits, bool strict) {
    Tally tally;
    for (size_t i = 0; i < rays.size(); ++i) {
        const hard::Judgement judgement = oracle.judge(rays[i], hits[i], strict);
        const Verdict got = judgement.verdict;
        const bool open = !strict && oracle.isOpen(rays[i]);
        ++tally.rays;
        tally.hits += got == Verdict::missed || (hits[i].primitive != NO_HIT && got != Verdict::phantom);
        tally.open += open;
        tally.unsound += !judgement.sound;
        if (!open) ++tally.counts[got];
        if (judgement.isFault() && tally.first.empty())
            tally.first = fmt::format("ray {} {} finds {} and should find {}", i, hard::describe(rays[i]),
                                      hard::describe(hits[i]), hard::describe(oracle.closest(rays[i])));
    }
    return tally;
}

}  // namespace raig::test
