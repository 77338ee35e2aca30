/// What of a structure is to be drawn for an item buffer: groups of references that may be seen, and instances.
#pragma once

#include "device/raster.hpp"
#include "rays/item_view.hpp"
#include "structures/structure.hpp"

#include <vector>

namespace raig {

/// Draws, and the list of instances that they name.
struct ItemDraws {
    std::vector<Draw> draws;
    std::vector<uint32_t> instances;
};

/// What is known of a structure's references: where groups of them lie.
class DrawnGroups {
public:
    /// O(references), in parallel.
    explicit DrawnGroups(const Structure& structure);

    /// What may be seen, whatever its size; of two levels those instances that are an item across, the nearest first, until
    /// `mostTriangles` are drawn: where a forest has more than that, what is left out is traced without a hint.
    ItemDraws seenBy(const ItemProjection& projection, uint64_t mostTriangles) const;

    uint32_t instancesAt() const { return instancesAt_; }

private:
    struct Group {
        Box box;
        uint32_t first = 0;
        uint32_t count = 0;
    };
    struct Placed {
        Box box;
        uint32_t bottom = 0;
    };
    struct Drawn {
        uint32_t referencesAt = 0;  ///< in uvec4
        uint32_t count = 0;
    };

    void addGroups(const Structure& structure);
    void addInstances(const Structure& structure);

    std::vector<Group> groups_;   ///< of one level
    std::vector<Placed> placed_;  ///< of two levels: instances
    std::vector<Drawn> bottoms_;
    uint32_t instancesAt_ = 0;
};

/// Cuts draws into pieces of at most that many triangles, in order.
std::vector<Draw> piecesOf(std::span<const Draw> draws, uint32_t mostTriangles);

}  // namespace raig
