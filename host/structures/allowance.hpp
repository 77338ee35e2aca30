/// What a builder that cuts space may still add.
#pragma once

#include <cstdint>

namespace raig {

/// References, and words (of four bytes) of nodes and references. Handed on to the parts of a cell in proportion: so that
/// what is built does not depend on the order in which tasks run, and never exceeds the whole.
struct Allowance {
    uint64_t references;
    uint64_t words;

    bool hasWords(uint64_t addedReferences, uint64_t addedWords) const { return addedReferences + addedWords <= words; }

    /// Takes off what a cut adds. False, and nothing taken, if it is too much.
    bool spend(uint64_t addedReferences, uint64_t addedWords) {
        if (addedReferences > references || !hasWords(addedReferences, addedWords)) return false;
        references -= addedReferences;
        words -= addedReferences + addedWords;
        return true;
    }

    /// The share of a part with `part` of `whole` references.
    Allowance share(uint64_t part, uint64_t whole) const {
        const double fraction = static_cast<double>(part) / static_cast<double>(whole);
        const auto of = [&](uint64_t all) { return static_cast<uint64_t>(static_cast<double>(all) * fraction); };
        return {of(references), of(words)};
    }
};

}  // namespace raig
