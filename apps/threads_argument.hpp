/// How many threads a command computes with.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "../core/threads.hpp"
#include "command.hpp"

namespace vcell {

class ThreadsArgument {
public:
    explicit ThreadsArgument(const char* preset = "0") : text_(preset) {}

    void add_to(CLI::App& command) {
        command
            .add_option("--threads", text_,
                        "how many to compute with, 0 for all cores; the result is the same")
            ->check([](const std::string& text) { return text == "0" ? "" : count_complaint(text); })
            ->type_name("N")
            ->capture_default_str();
    }
    /// Pre: the command line was parsed.
    unsigned count() const { return thread_count(static_cast<unsigned>(std::stoul(text_))); }

private:
    std::string text_;
};

}  // namespace vcell
