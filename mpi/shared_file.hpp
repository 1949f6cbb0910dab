/// An output that all ranks write a part of.
#pragma once

#include <memory>
#include <string>

#include "../io/files/files.hpp"
#include "ranks.hpp"

namespace vcell::mpi {

/// Appears under its name when it is complete, as OutputFile does: the first rank has one, hidden, and all
/// write to it. "-", devices and pipes are written by the first rank, which has one other's part at a time.
/// All members are called by all ranks; what throws throws SharedFailure.
class SharedFile {
public:
    /// Creates the file, so that a target that cannot be written is known before the work.
    SharedFile(Ranks& ranks, const std::string& target);

    const std::string& target() const { return target_; }
    /// The file until commit(), for all ranks to write to; empty where it is the first rank's alone.
    const std::string& hidden() const { return hidden_; }
    /// What all ranks have written, in their order. Called once.
    void write(const std::string& part);
    /// All bytes have reached the file.
    void close();
    /// Gives the file its name. Pre: closed.
    void commit();

private:
    void write_by_first(const std::string& part);
    void check(int error);

    Ranks& ranks_;
    std::string target_, hidden_;
    std::unique_ptr<OutputFile> file_;  // of the first rank
};

}  // namespace vcell::mpi
