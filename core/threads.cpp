#include "threads.hpp"

#include <condition_variable>
#include <mutex>
#include <system_error>

namespace vcell {

unsigned thread_count(unsigned asked) {
    return asked != 0 ? asked : std::max(1u, std::thread::hardware_concurrency());
}

namespace threads {

namespace {

class Line {
public:
    Line(std::size_t count, std::size_t ahead, const Task& make, const Task& take)
        : count_(count), ahead_(ahead), make_(make), take_(take), made_(ahead) {}

    // What threads other than the calling one do.
    void help() {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [&] { return may_begin() || is_over(); });
            if (is_over()) return;
            make_next(lock);
        }
    }

    // What the calling thread does. The exception that is to be rethrown once the others have ended, if any.
    std::exception_ptr lead() {
        std::unique_lock lock(mutex_);
        while (taken_ < count_) {
            Made& first = made_[taken_ % ahead_];
            if (first.is_there) {
                std::exception_ptr failure = std::exchange(first.failure, nullptr);
                if (!failure) {
                    lock.unlock();
                    try {
                        take_(taken_);
                    } catch (...) {
                        failure = std::current_exception();
                    }
                    lock.lock();
                }
                first.is_there = false;
                if (failure) {
                    has_failed_ = true;
                    changed_.notify_all();
                    return failure;
                }
                ++taken_;
                changed_.notify_all();
            } else if (may_begin()) {
                make_next(lock);
            } else {
                changed_.wait(lock, [&] { return first.is_there || may_begin(); });
            }
        }
        return nullptr;
    }

private:
    struct Made {
        bool is_there = false;
        std::exception_ptr failure;
    };

    bool may_begin() const { return !is_over() && begun_ < taken_ + ahead_; }
    bool is_over() const { return has_failed_ || begun_ == count_; }

    void make_next(std::unique_lock<std::mutex>& lock) {
        const std::size_t i = begun_++;
        lock.unlock();
        std::exception_ptr failure;
        try {
            make_(i);
        } catch (...) {
            failure = std::current_exception();
        }
        lock.lock();
        has_failed_ = has_failed_ || failure;
        made_[i % ahead_] = {true, std::move(failure)};
        changed_.notify_all();
    }

    const std::size_t count_, ahead_;
    const Task &make_, &take_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Made> made_;  // of the tasks taken_ <= i < begun_
    std::size_t begun_ = 0, taken_ = 0;
    bool has_failed_ = false;
};

}  // namespace

void run(std::size_t count, unsigned threads, std::size_t ahead, const Task& make, const Task& take) {
    if (threads <= 1 || count <= 1) {
        for (std::size_t i = 0; i < count; ++i) {
            make(i);
            take(i);
        }
        return;
    }
    Line line(count, ahead, make, take);
    std::vector<std::thread> others;
    others.reserve(threads - 1);
    try {
        for (unsigned t = 1; t < threads && t < count; ++t) others.emplace_back(&Line::help, &line);
    } catch (const std::system_error&) {
        // Those there are will do.
    }
    const std::exception_ptr failure = line.lead();
    for (std::thread& t : others) t.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace threads

void SharedProgress::add(double share) {
    if (is_cancelled_) throw Cancelled();
    const double done = done_ += share;
    if (!callback_ || std::this_thread::get_id() != caller_) return;
    try {
        callback_(done);
    } catch (...) {
        cancellation_ = std::current_exception();
        is_cancelled_ = true;
        throw;
    }
}

}  // namespace vcell
