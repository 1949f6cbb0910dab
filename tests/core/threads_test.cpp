#include "../../core/threads.hpp"

#include <doctest/doctest.h>

#include <chrono>
#include <set>
#include <stdexcept>
#include <string>

namespace vcell::threads_test {

TEST_CASE("threads: every task is done once, whatever their number") {
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        for (const std::size_t count : {0u, 1u, 2u, 7u, 1000u}) {
            std::vector<int> done(count, 0);
            for_all(count, threads, [&](std::size_t i) { ++done[i]; });
            CHECK(done == std::vector<int>(count, 1));
        }
        std::vector<int> elements(3 * elements_of_task + 5, 0);
        std::vector<std::size_t> tasks(range_count(elements.size()), 0);
        for_ranges(elements.size(), threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
            for (std::size_t i = begin; i < end; ++i) elements[i] += task_of(i) == task;
            tasks[task] = end - begin;
        });
        CHECK(elements == std::vector<int>(elements.size(), 1));
        CHECK(tasks == std::vector<std::size_t>{elements_of_task, elements_of_task, elements_of_task, 5});
    }
}

TEST_CASE("threads: results are taken in order by the calling thread, and few of them wait") {
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        constexpr std::size_t count = 500;
        std::atomic<std::size_t> made{0};
        std::size_t taken = 0, most_waiting = 0;
        const std::thread::id caller = std::this_thread::get_id();
        bool is_caller = true, is_ordered = true;
        in_order(
            count, threads,
            [&](std::size_t i) {
                ++made;
                return std::to_string(i);
            },
            [&](std::size_t i, const std::string& result) {
                is_ordered = is_ordered && i == taken && result == std::to_string(i);
                is_caller = is_caller && std::this_thread::get_id() == caller;
                most_waiting = std::max(most_waiting, made - taken);
                ++taken;
            });
        CHECK(taken == count);
        CHECK(is_ordered);
        CHECK(is_caller);
        CHECK(most_waiting <= 4 * threads);
    }
}

TEST_CASE("threads: the exception is that of the lowest task, as one thread meets it") {
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        for (int round = 0; round < 20; ++round) {
            std::set<std::size_t> taken;
            // Later ones fail sooner.
            const auto make = [](std::size_t i) {
                if (i == 23) std::this_thread::sleep_for(std::chrono::milliseconds(2));
                if (i >= 23) throw std::runtime_error("task " + std::to_string(i));
                return i;
            };
            std::string message;
            try {
                in_order(100, threads, make, [&](std::size_t i, std::size_t) { taken.insert(i); });
            } catch (const std::runtime_error& e) {
                message = e.what();
            }
            CHECK(message == "task 23");
            CHECK(taken.size() == 23);
            CHECK_THROWS_WITH(for_all(100, threads, make), "task 23");
        }
        CHECK_THROWS_WITH(in_order(
                              100, threads, [](std::size_t i) { return i; },
                              [](std::size_t i, std::size_t) {
                                  if (i == 7) throw std::runtime_error("taken");
                              }),
                          "taken");
    }
}

TEST_CASE("threads: what a callback throws comes out, and the callback is the calling thread's") {
    struct Cancel {};
    for (const unsigned threads : {1u, 2u, 3u, 8u}) {
        CAPTURE(threads);
        const std::thread::id caller = std::this_thread::get_id();
        double last = 0;
        bool is_caller = true, ascends = true;
        const std::function<void(double)> told = [&](double done) {
            is_caller = is_caller && std::this_thread::get_id() == caller;
            ascends = ascends && done >= last;
            last = done;
        };
        SharedProgress progress(told);
        for_all(1000, threads, [&](std::size_t) { progress.add(0x1p-10); });
        progress.add(24 * 0x1p-10);
        CHECK(is_caller);
        CHECK(ascends);
        CHECK(last == 1);

        const std::function<void(double)> cancel = [](double) { throw Cancel{}; };
        SharedProgress cancelled(cancel);
        std::atomic<int> begun{0};
        const auto work = [&] {
            for_all(1000, threads, [&](std::size_t) {
                ++begun;
                for (int i = 0; i < 1000; ++i) {
                    std::this_thread::sleep_for(std::chrono::microseconds(10));
                    cancelled.add(1e-6);
                }
            });
        };
        CHECK_THROWS_AS(cancelled.cancellable(work), Cancel);
        CHECK(begun < 1000);
    }
}

}  // namespace vcell::threads_test
