/// Work on several threads that leaves the same bytes for any number of them.
///
/// What there is to do is cut into tasks by the work alone, and tasks are numbered. They begin in ascending
/// order, what they leave is put together in ascending order by the calling thread. Once one has thrown no
/// more begin, and the exception of the lowest one is rethrown when all that had begun have ended: every task
/// below it has begun, so it is the one that a single thread meets. New threads compute as the calling one
/// does (core/platform.hpp): they inherit the mode of its floating-point unit.
#pragma once

#include "platform.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace vcell {

/// `asked`, or as many as the machine has cores where that is 0.
unsigned thread_count(unsigned asked);

namespace threads {

using Task = std::function<void(std::size_t)>;

/// make(i) for all i < count on some threads, the calling one among them, each followed by take(i) on the
/// calling thread, ascending in i. make(i) begins after take(i - ahead) has ended. Where the system has no
/// more threads to give those there are do it.
void run(std::size_t count, unsigned threads, std::size_t ahead, const Task& make, const Task& take);

}  // namespace threads

/// task(i) for all i < count.
template <class F>
void for_all(std::size_t count, unsigned threads, const F& task) {
    threads::run(count, threads, count, std::cref(task), [](std::size_t) {});
}

/// Elements as one task: some thousandths of a second, so that starting tasks costs next to nothing.
constexpr std::size_t elements_of_task = 2048;

/// Which task of for_ranges() an element belongs to.
constexpr std::size_t task_of(std::size_t element) { return element / elements_of_task; }

/// The number of tasks for_ranges() has.
constexpr std::size_t range_count(std::size_t elements) {
    return elements / elements_of_task + (elements % elements_of_task != 0);
}

/// task(begin, end), or task(begin, end, i) of the i-th task, for all elements in ranges of elements_of_task.
template <class F>
void for_ranges(std::size_t elements, unsigned threads, const F& task) {
    for_all(range_count(elements), threads, [&](std::size_t i) {
        const std::size_t begin = i * elements_of_task, end = std::min(elements, begin + elements_of_task);
        if constexpr (std::is_invocable_v<F, std::size_t, std::size_t, std::size_t>)
            task(begin, end, i);
        else
            task(begin, end);
    });
}

/// visit(element) for all elements of a vector.
template <class Elements, class F>
void for_each(Elements& elements, unsigned threads, const F& visit) {
    for_ranges(elements.size(), threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) visit(elements[i]);
    });
}

/// take(i, make(i)) for all i < count: make on any thread, take on the calling one, ascending in i. So few
/// results wait for take that memory stays bounded: four for each thread.
template <class Make, class Take>
void in_order(std::size_t count, unsigned threads, const Make& make, const Take& take) {
    constexpr std::size_t waiting_for_each = 4;
    const std::size_t ahead = std::max<std::size_t>(1, std::min(count, waiting_for_each * threads));
    std::vector<std::optional<decltype(make(std::size_t{}))>> results(ahead);
    threads::run(
        count, threads, ahead, [&](std::size_t i) { results[i % ahead].emplace(make(i)); },
        [&](std::size_t i) {
            take(i, *std::move(results[i % ahead]));
            results[i % ahead].reset();
        });
}

/// What is done of some work on several threads, told to a callback that may throw to cancel all of it. The
/// callback is called by the thread alone that makes this object.
class SharedProgress {
public:
    /// `callback` gets the fraction that is done; it may be empty, and must outlive this object.
    explicit SharedProgress(const std::function<void(double)>& callback)
        : callback_(callback), caller_(std::this_thread::get_id()) {}

    /// Another share is done, by whichever thread.
    void add(double share);
    /// work(), in which any thread may add(). What the callback throws comes out of it, whatever exceptions
    /// other threads end by then.
    template <class F>
    decltype(auto) cancellable(F&& work) {
        try {
            return work();
        } catch (...) {
            if (is_cancelled_) std::rethrow_exception(cancellation_);
            throw;
        }
    }

private:
    struct Cancelled {};

    const std::function<void(double)>& callback_;
    const std::thread::id caller_;
    std::atomic<double> done_{0};
    std::atomic<bool> is_cancelled_{false};
    std::exception_ptr cancellation_;  // written before is_cancelled_
};

}  // namespace vcell
