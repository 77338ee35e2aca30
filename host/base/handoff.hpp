/// What passes from the thread that starts parallel work to those that do it, and back: told to the thread sanitizer, which
/// cannot look into oneTBB's library. Nothing at all in other builds.
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace raig {

/// Lives on the stack of the thread that starts the work, around the call that does.
class Handoff {
#ifdef __SANITIZE_THREAD__
public:
    Handoff() { __tsan_release(&begun_); }
    ~Handoff() { __tsan_acquire(&done_); }
    Handoff(const Handoff&) = delete;
    Handoff& operator=(const Handoff&) = delete;

    /// Lives on the stack of the thread that does a piece of it, around the piece.
    class Piece {
    public:
        explicit Piece(Handoff& handoff) : handoff_(handoff) { __tsan_acquire(&handoff_.begun_); }
        ~Piece() { __tsan_release(&handoff_.done_); }
        Piece(const Piece&) = delete;
        Piece& operator=(const Piece&) = delete;

    private:
        Handoff& handoff_;
    };

private:
    char begun_ = 0, done_ = 0;
#else
public:
    Handoff() {}
    struct Piece {
        explicit Piece(Handoff&) {}
    };
#endif
};

}  // namespace raig
