#pragma once

#include <span>
#include <utility>
#include <vector>

namespace ff::ecs {

/// Things that happened, in the order they were sent, kept for exactly one tick: send() fills one buffer while read()
/// shows the other; swap() exchanges them. So it does not matter whether a reader runs before or after the writer.
/// Threads: one writer at a time (Schedule sees to it where the queue is declared), any number of readers.
template <class T>
class EventQueue {
  public:
    void send(T event) { sent_.push_back(std::move(event)); }
    /// What was sent in the tick before.
    [[nodiscard]] std::span<const T> read() const { return readable_; }
    /// Forgets what was readable and makes readable what was sent. Keeps both buffers' memory.
    void swap() {
        readable_.clear();
        std::swap(readable_, sent_);
    }

  private:
    std::vector<T> sent_, readable_;
};

}  // namespace ff::ecs
