#include "base/part_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <utility>

namespace raig {

namespace {

constexpr std::array<int, 3> endingSignals = {SIGHUP, SIGINT, SIGTERM};

sigset_t endingSet() {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : endingSignals) sigaddset(&set, signal);
    return set;
}

/// All part files of the program. Whoever holds the lock may change the list, or make and rename the files of it; the signal
/// handler takes it too and never gives it back, so that no file appears after it looked.
std::atomic_flag locked;
PartFile* firstPart = nullptr;

/// As a signal handler may.
void takeLock() {
    const timespec moment{0, 100'000};
    while (locked.test_and_set(std::memory_order_acquire)) ::nanosleep(&moment, nullptr);
}

/// Holds the lock, with the signals off in this thread: a handler in it would wait for itself.
class Lock {
public:
    Lock() {
        const sigset_t set = endingSet();
        pthread_sigmask(SIG_BLOCK, &set, &before_);
        takeLock();
    }
    ~Lock() {
        locked.clear(std::memory_order_release);
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

private:
    sigset_t before_;
};

}  // namespace

PartFile::PartFile(std::string path) : path_(std::move(path)) {
    const Lock lock;
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_CREAT | O_TRUNC, 0666);
    if (descriptor_ < 0) return;
    exists_ = true;
    next_ = std::exchange(firstPart, this);
}

PartFile::~PartFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    const Lock lock;
    if (exists_) ::unlink(path_.c_str());
    for (PartFile** at = &firstPart; *at != nullptr; at = &(*at)->next_)
        if (*at == this) {
            *at = next_;
            break;
        }
}

bool PartFile::putInPlace(const std::string& target) {
    if (::close(std::exchange(descriptor_, -1)) != 0) return false;  // a full network disk says so only here
    const Lock lock;
    if (std::rename(path_.c_str(), target.c_str()) != 0) return false;
    exists_ = false;
    return true;
}

/// The signal handler: calls only what POSIX lets one call.
void removePartFiles(int signal) {
    takeLock();
    for (const PartFile* part = firstPart; part != nullptr; part = part->next_)
        if (part->exists_) ::unlink(part->path_.c_str());
    std::signal(signal, SIG_DFL);
    std::raise(signal);  // ends the program as soon as the handler returns
}

void removePartFilesOnSignals() {
    struct sigaction action {};
    action.sa_handler = removePartFiles;
    action.sa_mask = endingSet();
    for (const int signal : endingSignals) {
        struct sigaction before {};
        if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
    }
}

}  // namespace raig
