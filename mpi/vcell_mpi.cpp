// The vcell-mpi program: whole diagrams by many processes, also on many machines.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "../io/files/files.hpp"
#include "mpi_diagram.hpp"
#include "ranks.hpp"

namespace vcell::mpi {

namespace {

int run(Ranks& ranks, int argc, char** argv) {
    CLI::App app("Voronoi diagrams of objects, by many processes.", "vcell-mpi");
    app.footer(
        "Example:\n  mpirun -n 8 vcell-mpi diagram balls.xyzr --cells cells.tsv --contacts contacts.tsv");
    app.set_version_flag("--version", "vcell-mpi " VCELL_VERSION);
    app.require_subcommand(1);
    app.failure_message([](const CLI::App*, const CLI::Error& e) {
        return fmt::format("vcell-mpi: {}; \"vcell-mpi --help\" tells more\n", e.what());
    });
    const MpiDiagram diagram(app);
    try {
        app.parse(arguments(argc, argv));
    } catch (const CLI::ParseError& e) {
        // All ranks have the same command line; one says what is wrong with it.
        if (!ranks.is_first()) return e.get_exit_code() == 0 ? done : wrong_usage;
        return app.exit(e) == 0 ? done : wrong_usage;
    }
    try {
        return diagram.run(ranks);
    } catch (const SharedFailure& e) {
        if (ranks.is_first()) fmt::print(stderr, "vcell: {}\n", e.failure.text);
        return e.failure.status;
    }
}

}  // namespace

}  // namespace vcell::mpi

int main(int argc, char** argv) {
    using namespace vcell;
    mpi::Ranks ranks(argc, argv);
    remove_unfinished_on_signals();
    try {
        return mpi::run(ranks, argc, argv);
    } catch (...) {
        // The other ranks wait for this one.
        const Failure failure = failure_of_exception();
        fmt::print(stderr, "vcell: rank {}: {}\n", ranks.rank(), failure.text);
        MPI_Abort(ranks.all(), failure.status);
        return failure.status;
    }
}
