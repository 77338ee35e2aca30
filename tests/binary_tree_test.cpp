#include "structures/bvh_builders.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

std::vector<BoxReference> referencesOf(const std::vector<Primitive>& primitives) {
    std::vector<BoxReference> references;
    for (const Primitive& primitive : primitives) {
        const Box box = primitive.box();
        references.push_back({box.lo, static_cast<uint32_t>(references.size()), box.hi, 0});
    }
    return references;
}

/// What a walk from the root meets, in order: the boxes of all nodes and the references of leaves.
struct Met {
    std::vector<vec3> corners;
    std::vector<uint32_t> ids;
    bool operator==(const Met&) const = default;
};

Met walkAll(const BinaryTree& tree) {
    Met met;
    std::vector<uint32_t> pending{0};
    while (!pending.empty()) {
        const BinaryNode& node = tree.nodes.at(pending.back());
        pending.pop_back();
        met.corners.insert(met.corners.end(), {node.box.lo, node.box.hi});
        for (uint32_t i = 0; i < node.count; ++i) met.ids.push_back(tree.references.at(node.first + i).id);
        if (node.count == 0)
            for (const uint32_t child : tree.childrenOf(node)) pending.push_back(child);
    }
    return met;
}

TEST(BinaryTree, IsTheSameTreeOnceCompacted) {
    for (const uint32_t arity : {2u, 4u, 8u}) {
        BinaryTree tree = buildBinnedSah(referencesOf(test::sphere(30, 1.0, dvec3(0), 0.1)), /* maxLeaf= */ 4, {});
        if (arity > 2) widen(tree, arity);
        const Met before = walkAll(tree);
        const size_t reached = before.corners.size() / 2;
        EXPECT_LT(reached, tree.nodes.size()) << "the builder left no gaps to close";
        compact(tree);
        EXPECT_EQ(tree.nodes.size(), reached) << arity;
        EXPECT_EQ(walkAll(tree), before) << arity;
    }
}

TEST(BinaryTree, IsNothingOnceCompactedWhereNothingWasGiven) {
    BinaryTree tree;
    compact(tree);
    EXPECT_TRUE(tree.nodes.empty());
}

}  // namespace
}  // namespace raig
