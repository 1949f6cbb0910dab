/// Workers that keep their memory from task to task, as many as there are tasks at a time.
#pragma once

#include "platform.hpp"

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace vcell {

template <class Worker>
class WorkerPool {
public:
    /// make() gives a new worker.
    explicit WorkerPool(std::function<std::unique_ptr<Worker>()> make) : make_(std::move(make)) {}

    /// work(worker), with one that nobody else has for the time. Any thread may call it.
    template <class Work>
    decltype(auto) with_one(Work&& work) {
        Worker& worker = take();
        struct Return {
            WorkerPool& pool;
            Worker& worker;
            ~Return() {
                const std::lock_guard lock(pool.mutex_);
                pool.free_.push_back(&worker);
            }
        };
        const Return at_end{*this, worker};
        return work(worker);
    }
    /// Pre: none is taken.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (const auto& worker : workers_) visit(*worker);
    }

private:
    Worker& take() {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) {
            free_.reserve(workers_.size() + 1);  // that it takes all back without more memory
            return *workers_.emplace_back(make_());
        }
        Worker* const worker = free_.back();
        free_.pop_back();
        return *worker;
    }

    const std::function<std::unique_ptr<Worker>()> make_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<Worker*> free_;
};

}  // namespace vcell
