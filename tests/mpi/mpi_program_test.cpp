// vcell-mpi: the bytes of vcell, whatever the number of ranks and threads.
#include <doctest/doctest.h>
#ifdef VCELL_HAS_HDF5
#include <hdf5.h>
#endif

#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "../apps/workplace.hpp"
#include "../io/vtu_arrays.hpp"
#include "../test_support.hpp"

namespace {

/// Standard output, standard error and tables of a run.
struct Run {
    Outcome outcome;
    std::string cells, contacts;
};

Run read_tables(const Workplace& work, Outcome outcome) {
    return {std::move(outcome), work.read("cells.tsv"), work.read("contacts.tsv")};
}
Run by_vcell(const Workplace& work, const std::string& arguments) {
    return read_tables(
        work, work.run("diagram " + arguments + " --threads 1 --cells cells.tsv --contacts contacts.tsv"));
}

// More ranks than cores, by any user: Open MPI wants to be told. When a rank aborts it would wait a second
// before it kills the others, which have nothing to save.
std::string mpirun(int ranks) {
    return "env OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_odls_base_sigkill_timeout=0 "
           "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
           "OMPI_MCA_btl_vader_single_copy_mechanism=none " VCELL_MPIRUN " " +
           std::to_string(ranks) + " '" VCELL_MPI_PROGRAM "' ";
}
Run by_mpi(const Workplace& work, int ranks, const std::string& arguments) {
    return read_tables(work, work.run_command(mpirun(ranks) + "diagram " + arguments +
                                              " --cells cells.tsv --contacts contacts.tsv"));
}

void check_same(const Workplace& work, const std::string& arguments, const std::vector<int>& ranks) {
    const Run one = by_vcell(work, arguments);
    CAPTURE(one.outcome.err);
    REQUIRE(!one.cells.empty());
    REQUIRE(!one.contacts.empty());
    for (const int n : ranks) {
        CAPTURE(n);
        const Run many = by_mpi(work, n, arguments + (n == 2 ? " --threads 2" : ""));
        CAPTURE(many.outcome.err);
        CHECK(many.outcome.status == one.outcome.status);
        CHECK(many.outcome.out == one.outcome.out);
        CHECK(many.cells == one.cells);
        CHECK(many.contacts == one.contacts);
        // mpirun has its own words about a status that is not 0.
        CHECK(many.outcome.err.starts_with(one.outcome.err));
    }
}

std::string random_balls(std::mt19937_64& rng, int count, double largest, bool are_named) {
    std::uniform_real_distribution<double> place(0, 1), size(0, 1);
    std::ostringstream text;
    text.precision(17);
    for (int i = 0; i < count; ++i) {
        text << place(rng) << ' ' << place(rng) << ' ' << place(rng) << ' '
             << largest * std::pow(size(rng), 3);
        if (are_named) text << " atom" << i << " group" << i % 7;
        text << '\n';
    }
    return text.str();
}

#ifdef VCELL_HAS_HDF5
/// A list of the file.
template <class T>
std::vector<T> list(hid_t file, const char* name, hid_t type) {
    const hid_t data = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(data);
    REQUIRE(data >= 0);
    std::vector<T> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    CHECK(H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    H5Sclose(space);
    H5Dclose(data);
    return values;
}
#endif

}  // namespace

#ifdef VCELL_HAS_HDF5
TEST_CASE("vcell-mpi: a grid is one file of the same bytes, and its triangles enclose the cells' volumes") {
    std::mt19937_64 rng(vcell::test_seed());
    const Workplace work;
    work.write("balls.txt", random_balls(rng, 12, 0.1, false) + "0.5 0.5 0.5 0.2\n0.5 0.5 0.5 0.1\n");
    const std::string arguments = "diagram balls.txt --box -0.1 -0.1 -0.1 1.1 1.1 1.1 --cells cells.tsv -o ";
    std::string first;
    for (const int n : {1, 2, 8}) {
        CAPTURE(n);
        const Outcome done = work.run_command(mpirun(n) + arguments + "cells.vtkhdf");
        CAPTURE(done.err);
        REQUIRE(done.status == 0);
        if (first.empty()) first = work.read("cells.vtkhdf");
        CHECK(work.read("cells.vtkhdf") == first);
    }
    const std::string cells = work.read("cells.tsv");
    CHECK(work.run(arguments + "cells.vtu").status == 0);
    CHECK(work.read("cells.tsv") == cells);
    const hid_t file = H5Fopen(work.path("cells.vtkhdf").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    REQUIRE(file >= 0);
    const auto points = list<double>(file, "/VTKHDF/Points", H5T_NATIVE_DOUBLE);
    const auto corners = list<std::int64_t>(file, "/VTKHDF/Connectivity", H5T_NATIVE_INT64),
               offsets = list<std::int64_t>(file, "/VTKHDF/Offsets", H5T_NATIVE_INT64),
               owners = list<std::int64_t>(file, "/VTKHDF/CellData/cell", H5T_NATIVE_INT64);
    const auto volumes = list<double>(file, "/VTKHDF/CellData/volume", H5T_NATIVE_DOUBLE);
    CHECK(list<std::int64_t>(file, "/VTKHDF/NumberOfPoints", H5T_NATIVE_INT64)[0] * 3 ==
          static_cast<std::int64_t>(points.size()));
    CHECK(list<std::int64_t>(file, "/VTKHDF/NumberOfConnectivityIds", H5T_NATIVE_INT64)[0] ==
          static_cast<std::int64_t>(corners.size()));
    CHECK(list<std::uint8_t>(file, "/VTKHDF/Types", H5T_NATIVE_UINT8) ==
          std::vector<std::uint8_t>(owners.size(), 5));
    H5Fclose(file);
    REQUIRE(offsets.size() == owners.size() + 1);
    std::map<std::int64_t, double> enclosed;
    std::map<std::int64_t, double> said;
    for (std::size_t t = 0; t < owners.size(); ++t) {
        REQUIRE(offsets[t] == static_cast<std::int64_t>(3 * t));
        const auto at = [&](std::size_t k, int axis) {
            return points.at(3 * static_cast<std::size_t>(corners[3 * t + k]) +
                             static_cast<std::size_t>(axis));
        };
        // Six times the tetrahedron from the origin.
        double six = 0;
        for (int x = 0; x < 3; ++x) {
            const int y = (x + 1) % 3, z = (x + 2) % 3;
            six += at(0, x) * (at(1, y) * at(2, z) - at(1, z) * at(2, y));
        }
        enclosed[owners[t]] += six / 6;
        said[owners[t]] = volumes[t];
    }
    REQUIRE(said.size() >= 10);
    CHECK(said.count(13) == 0);  // hidden
    double sum = 0;
    for (const auto& [cell, volume] : said) {
        CAPTURE(cell);
        CHECK(std::abs(enclosed[cell] - volume) < 0.02 * volume);
        sum += volume;
    }
    CHECK(sum == doctest::Approx(1.2 * 1.2 * 1.2));
}

// Ranks draw cells in another order for each number of them.
TEST_CASE("vcell-mpi: meshes are those of vcell, triangle for triangle") {
    std::mt19937_64 rng(vcell::test_seed());
    const Workplace work;
    work.write("balls.txt", random_balls(rng, 50, 0.16, false));
    // All their vertices are degenerate.
    std::string lattice;
    for (int i = 0; i < 64; ++i)
        if (const int x = i % 4, y = i / 4 % 4, z = i / 16; (x + y + z) % 2 == 0)
            lattice += std::to_string(x) + ' ' + std::to_string(y) + ' ' + std::to_string(z) + " 0.5\n";
    work.write("fcc.txt", lattice);
    const auto bytes_of = [](const auto& values) {
        return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
    };
    for (const std::string scene :
         {"balls.txt --box 0 0 0 1 1 1 --chord 1%",
          "balls.txt --box 0 0 0 1 1 1 --periodic xyz --tilt 0.3 0.1 -0.2 --chord 1%",
          "balls.txt --box -0.2 -0.2 -0.2 1.2 1.2 1.2 --probe 0.1 --chord 1%",
          "fcc.txt --box 0 0 0 4 4 4 --periodic xyz", "'" VCELL_EXAMPLE_SCENES "/hopper.json' --chord 1%",
          "'" VCELL_EXAMPLE_SCENES "/fibres_in_tube.json' --chord 1%"}) {
        CAPTURE(scene);
        REQUIRE(work.run("diagram " + scene + " -o one.vtu").status == 0);
        const std::string one = work.read("one.vtu");
        std::string first;
        for (const int n : {1, 4}) {
            CAPTURE(n);
            const Outcome done = work.run_command(mpirun(n) + "diagram " + scene + " -o many.vtkhdf" +
                                                  (n == 4 ? " --threads 2" : ""));
            CAPTURE(done.err);
            REQUIRE(done.status == 0);
            if (first.empty()) first = work.read("many.vtkhdf");
            CHECK(work.read("many.vtkhdf") == first);
        }
        const hid_t file = H5Fopen(work.path("many.vtkhdf").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
        REQUIRE(file >= 0);
        const auto is_same = [&](const char* name, const auto& values) {
            return vcell::testing::array_of(one, name) == bytes_of(values);
        };
        CHECK(is_same("connectivity", list<std::int32_t>(file, "/VTKHDF/Connectivity", H5T_NATIVE_INT32)));
        CHECK(is_same("clearance", list<double>(file, "/VTKHDF/PointData/clearance", H5T_NATIVE_DOUBLE)));
        CHECK(is_same("cell", list<std::int32_t>(file, "/VTKHDF/CellData/cell", H5T_NATIVE_INT32)));
        CHECK(is_same("neighbor", list<std::int32_t>(file, "/VTKHDF/CellData/neighbor", H5T_NATIVE_INT32)));
        CHECK(is_same("Points", list<double>(file, "/VTKHDF/Points", H5T_NATIVE_DOUBLE)));
        H5Fclose(file);
    }
}
#endif

TEST_CASE("vcell-mpi: balls of all sizes, hidden ones and a huge one among them") {
    std::mt19937_64 rng(vcell::test_seed());
    const Workplace work;
    // The last three: in the huge ball, equal to another one, and outside the box's middle third.
    work.write("balls.txt",
               random_balls(rng, 200, 0.1, true) +
                   "0.5 0.5 0.5 0.3 huge\n0.5 0.5 0.6 0.1 inner\n0.9 0.9 0.05 0.02\n0.9 0.9 0.05 0.02\n");
    check_same(work, "balls.txt --box -0.1 -0.1 -0.1 1.1 1.1 1.1", {1, 2, 4, 8});
}

TEST_CASE("vcell-mpi: boxes that repeat, and lattices whose neighbours are equally near") {
    std::mt19937_64 rng(vcell::test_seed());
    const Workplace work;
    work.write("balls.txt", random_balls(rng, 60, 0.08, false));
    check_same(work, "balls.txt --box 0 0 0 1 1 1 --periodic xyz --tilt 0.3 0.1 -0.2", {3, 8});
    std::ostringstream lattice;
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            for (int k = 0; k < 4; ++k) lattice << i << ' ' << j << ' ' << k << " 0.25\n";
    work.write("lattice.txt", lattice.str());
    check_same(work, "lattice.txt --box -0.5 -0.5 -0.5 4.5 4.5 3.5 --periodic xy", {2, 7});
    check_same(work, "lattice.txt --box -1 -1 -1 6 6 5", {4});
}

TEST_CASE("vcell-mpi: tubes in a box that repeats are known everywhere, with images of balls") {
    const Workplace work;
    for (const std::string tilt : {"0, 0, 0", "0.5, -0.25, 0.5"}) {
        work.write("scene.json", R"({"vcell": 1, "objects": [
            {"sphere": {"center": [0.25, 0.5, 0.25], "radius": 0.25}},
            {"sphere": {"center": [1.5, 1.25, 3.5], "radius": 0.125}},
            {"cylinder": {"point": [1, 0, 1.5], "axis": [1, 0, 0], "radius": 0.125}},
            {"sphere": {"center": [0.75, 1.5, 1.25], "radius": 0.25}},
            {"cylinder": {"point": [0.5, 1, 1.875], "axis": [2, 0, 0], "radius": 0.0625}}],
            "box": {"min": [0, 0, 0], "max": [2, 2, 2]}, "periodic": [true, true, true], "tilt": [)" +
                                     tilt + "]}");
        check_same(work, "scene.json", {1, 3, 8});
    }
}

TEST_CASE("vcell-mpi: fewer balls than ranks, so that some own nothing") {
    const Workplace work;
    work.write("balls.txt", "0 0 0 0.5\n2 0 0 0.5 B\n0 2 0 0.25\n");
    check_same(work, "balls.txt --box -2 -2 -2 4 4 2", {8});
    work.write("one.txt", "0.2 0.3 0.4 0.1\n");
    check_same(work, "one.txt --box 0 0 0 1 1 1 --periodic xyz", {4});
}

TEST_CASE("vcell-mpi: planes and tubes are known everywhere, balls outside the box see everything") {
    const Workplace work;
    work.write("scene.json", R"({"vcell": 1, "objects": [
        {"plane": {"point": [0, 0, -1], "normal": [0, 0, 1]}, "name": "floor"},
        {"sphere": {"center": [0, 0, 0], "radius": 0.5}},
        {"sphere": {"center": [1.4, 0.2, 0.5], "radius": 0.3}},
        {"cylinder": {"point": [-1.2, 0, 0], "axis": [0, 1, 0.2], "radius": 0.2}},
        {"sphere": {"center": [0.3, 1.5, 0.1], "radius": 0.2}},
        {"sphere": {"center": [0.3, 0.1, 2.2], "radius": 0.1}},
        {"sphere": {"center": [1.4, 0.2, 0.6], "radius": 0.1}}],
        "box": {"min": [-2, -2, -0.9], "max": [2, 2, 2]}})");
    check_same(work, "scene.json", {2, 5});
    // Vessels and planes are walls, what lies beyond has no cell, and what cuts a wall is refused.
    work.write("vessel.json", R"({"vcell": 1, "objects": [
        {"hollow_sphere": {"center": [0, 0, 0], "radius": 2}},
        {"sphere": {"center": [0, 0, 0], "radius": 0.5}},
        {"sphere": {"center": [1.0, 0.2, 0.5], "radius": 0.3}},
        {"sphere": {"center": [4, 0, 0], "radius": 0.5}},
        {"sphere": {"center": [0, 2, 0], "radius": 0.25}},
        {"hollow_cone": {"apex": [0, 0, -1.75], "axis": [0.125, 0, 1], "radius": 4, "slant": 5}}],
        "box": {"min": [-2, -2, -1], "max": [2, 2, 2]}})");
    check_same(work, "vessel.json", {4});
}

TEST_CASE("vcell-mpi: with a probe") {
    std::mt19937_64 rng(vcell::test_seed());
    const Workplace work;
    work.write("balls.txt", random_balls(rng, 50, 0.06, false) + "1.5 0.5 0.5 0.1\n");
    check_same(work, "balls.txt --box -0.3 -0.3 -0.3 1.3 1.3 1.3 --probe 0.1", {4});
}

TEST_CASE("vcell-mpi: what is wrong is said once, and all ranks end as vcell does") {
    const Workplace work;
    work.write("bad.txt", "0 0 0 1\n1 2 three 1\n");
    work.write("negative.txt", "0 0 0 1\n1 2 3 -1\n");
    work.write("good.txt", "0 0 0 1\n3 2 3 1\n");
    for (const std::string arguments :
         {"diagram bad.txt", "diagram negative.txt", "diagram nowhere.txt", "diagram good.txt --tilt 0.1 0 0",
          "diagram good.txt --cells no/where", "diagram good.txt --cells a --contacts a",
          "diagram good.txt --probe -1", "diagram good.txt --no-such-option", "diagram"}) {
        CAPTURE(arguments);
        const Outcome one = work.run(arguments), many = work.run_command(mpirun(3) + arguments);
        CAPTURE(many.err);
        CHECK(one.status != 0);
        CHECK(many.status == one.status);
        CHECK(many.out.empty());
        const std::string complaint = one.err.substr(one.err.find(": "));
        const std::size_t at = many.err.find(complaint.substr(0, complaint.find(';')));
        REQUIRE(at != std::string::npos);
        CHECK(many.err.find(complaint.substr(0, complaint.find(';')), at + 1) == std::string::npos);
    }
    CHECK(work.files() == std::vector<std::string>{"bad.txt", "good.txt", "negative.txt"});
}
