#include "grid_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "../core/errors.hpp"
#ifdef VCELL_HAS_HDF5
#include <hdf5.h>
#endif

namespace vcell::mpi {

OrderedMesh in_order(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered,
                     std::vector<std::optional<LabelledMesh>> meshes) {
    std::vector<Letter> to(ranks.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (!meshes[i]) continue;
        Letter& letter = to[range_of(parts.own[i].number, ranks.size(), parts.count)];
        letter.put(parts.own[i].number);
        letter.put(meshes[i]->points);
        letter.put(meshes[i]->clearance);
        letter.put(meshes[i]->triangles);
        letter.put(meshes[i]->neighbor);
        meshes[i].reset();
    }
    std::vector<LabelledMesh> of_range(ordered.cells.size());
    for (const Letter& letter : ranks.exchange(std::move(to)))
        for (LetterReader in(letter); !in.at_end();) {
            LabelledMesh& mesh = of_range[in.get<std::uint32_t>() - ordered.first];
            mesh.points = in.list<Vec3>();
            mesh.clearance = in.list<double>();
            mesh.triangles = in.list<Triangle>();
            mesh.neighbor = in.list<std::int32_t>();
        }
    OrderedMesh all;
    const auto append = [](auto& list, const auto& more) {
        list.insert(list.end(), more.begin(), more.end());
    };
    for (std::size_t i = 0; i < of_range.size(); ++i) {
        LabelledMesh& mesh = of_range[i];
        const auto before = static_cast<std::uint32_t>(all.mesh.points.size());
        append(all.mesh.points, mesh.points);
        append(all.mesh.clearance, mesh.clearance);
        append(all.mesh.neighbor, mesh.neighbor);
        for (const Triangle& t : mesh.triangles)
            all.mesh.triangles.push_back({t[0] + before, t[1] + before, t[2] + before});
        all.mesh.cell.resize(all.mesh.triangles.size(), static_cast<std::int32_t>(ordered.first + i));
        all.volume.resize(all.mesh.triangles.size(), ordered.cells[i].volume);
        mesh = {};
    }
    return all;
}

#ifdef VCELL_HAS_HDF5

namespace {

// A handle of HDF5 with the function that closes it.
class Handle {
public:
    using Close = herr_t (*)(hid_t);
    Handle(hid_t id, Close close) : id_(id), close_(close) {
        if (id_ < 0) throw InternalError("HDF5 refuses what a grid file is made of");
    }
    ~Handle() { close_(id_); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }

private:
    hid_t id_;
    Close close_;
};

void check(herr_t status) {
    if (status < 0) throw InternalError("HDF5 refuses what a grid file is made of");
}

// Every rank has the same calls in the same order, and writes the rows from its own on.
class GridWriter {
public:
    GridWriter(Ranks& ranks, hid_t group) : ranks_(ranks), group_(group) {}

    /// A number for all pieces, of which there is one.
    void count(const char* name, std::uint64_t total) {
        const std::array value{static_cast<std::int64_t>(total)};
        rows(group_, name, H5T_STD_I64LE, H5T_NATIVE_INT64, 1, ranks_.is_first() ? 1 : 0, value.data());
    }
    /// Rows of all ranks, in their order.
    void rows(hid_t group, const char* name, hid_t in_file, hid_t in_memory, hsize_t columns,
              std::uint64_t count, const void* values) {
        const hsize_t begin = ranks_.before(count), total = ranks_.sum(count);
        const std::array<hsize_t, 2> size{total, columns}, mine{count, columns}, from{begin, 0};
        const int dimensions = columns == 1 ? 1 : 2;
        const Handle space(H5Screate_simple(dimensions, size.data(), nullptr), H5Sclose),
            memory(H5Screate_simple(dimensions, mine.data(), nullptr), H5Sclose),
            creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
            transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
        // The same bytes at any time of day; every byte is written below.
        check(H5Pset_obj_track_times(creation, false));
        check(H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER));
        check(H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE));
        const Handle data(H5Dcreate2(group, name, in_file, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                          H5Dclose);
        if (total == 0) return;
        if (count == 0) {
            check(H5Sselect_none(space));
            check(H5Sselect_none(memory));
        } else {
            check(H5Sselect_hyperslab(space, H5S_SELECT_SET, from.data(), nullptr, mine.data(), nullptr));
        }
        // HDF5 takes no pointer to nothing.
        const double nothing = 0;
        check(H5Dwrite(data, in_memory, memory, space, transfer, values != nullptr ? values : &nothing));
    }

private:
    Ranks& ranks_;
    hid_t group_;
};

void write_attributes(hid_t group) {
    const std::array<std::int64_t, 2> version{1, 0};
    const hsize_t two = 2;
    const Handle pair(H5Screate_simple(1, &two, nullptr), H5Sclose), one(H5Screate(H5S_SCALAR), H5Sclose),
        text(H5Tcopy(H5T_C_S1), H5Tclose);
    const Handle as_version(H5Acreate2(group, "Version", H5T_STD_I64LE, pair, H5P_DEFAULT, H5P_DEFAULT),
                            H5Aclose);
    check(H5Awrite(as_version, H5T_NATIVE_INT64, version.data()));
    constexpr std::string_view type = "UnstructuredGrid";
    check(H5Tset_size(text, type.size()));
    check(H5Tset_strpad(text, H5T_STR_NULLPAD));
    const Handle as_type(H5Acreate2(group, "Type", text, one, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(as_type, text, type.data()));
}

void write_all(Ranks& ranks, const OrderedMesh& ordered, hid_t file) {
    const LabelledMesh& mesh = ordered.mesh;
    const std::uint64_t points = mesh.points.size(), triangles = mesh.triangles.size();
    const auto group = [&](hid_t in, const char* name) {
        const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
        check(H5Pset_obj_track_times(creation, false));
        return H5Gcreate2(in, name, H5P_DEFAULT, creation, H5P_DEFAULT);
    };
    const Handle root(group(file, "VTKHDF"), H5Gclose);
    const Handle of_points(group(root, "PointData"), H5Gclose), of_cells(group(root, "CellData"), H5Gclose);
    write_attributes(root);
    GridWriter out(ranks, root);
    const std::uint64_t all_triangles = ranks.sum(triangles);
    out.count("NumberOfPoints", ranks.sum(points));
    out.count("NumberOfCells", all_triangles);
    out.count("NumberOfConnectivityIds", 3 * all_triangles);
    {
        std::vector<double> coordinates;
        for (const Vec3& p : mesh.points) coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
        out.rows(root, "Points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, points, coordinates.data());
    }
    {
        const auto before = static_cast<std::int64_t>(ranks.before(points));
        std::vector<std::int64_t> corners;
        for (const Triangle& t : mesh.triangles)
            for (const std::uint32_t corner : t)
                corners.push_back(before + static_cast<std::int64_t>(corner));
        out.rows(root, "Connectivity", H5T_STD_I64LE, H5T_NATIVE_INT64, 1, corners.size(), corners.data());
    }
    {
        // One more than there are triangles: the last rank ends them.
        const auto before = static_cast<std::int64_t>(3 * ranks.before(triangles));
        std::vector<std::int64_t> offsets;
        const bool is_last = ranks.rank() + 1 == ranks.size();
        for (std::uint64_t t = 0; t < triangles + (is_last ? 1 : 0); ++t)
            offsets.push_back(before + 3 * static_cast<std::int64_t>(t));
        out.rows(root, "Offsets", H5T_STD_I64LE, H5T_NATIVE_INT64, 1, offsets.size(), offsets.data());
    }
    constexpr std::uint8_t triangle = 5;  // VTK_TRIANGLE
    const std::vector<std::uint8_t> types(triangles, triangle);
    out.rows(root, "Types", H5T_STD_U8LE, H5T_NATIVE_UINT8, 1, triangles, types.data());
    out.rows(of_points, "clearance", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1, points, mesh.clearance.data());
    out.rows(of_cells, "cell", H5T_STD_I32LE, H5T_NATIVE_INT32, 1, triangles, mesh.cell.data());
    out.rows(of_cells, "neighbor", H5T_STD_I32LE, H5T_NATIVE_INT32, 1, triangles, mesh.neighbor.data());
    out.rows(of_cells, "volume", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1, triangles, ordered.volume.data());
}

}  // namespace

bool has_grid_files() { return true; }

void write_grid(Ranks& ranks, const OrderedMesh& ordered, const SharedFile& file) {
    const auto refuse = [&](bool is_done) {
        ranks.together([&] {
            if (!is_done) throw WriteError(fmt::format("cannot write {}: HDF5 says no", file.target()));
        });
    };
    // What goes wrong is told in our words.
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    check(H5Pset_fapl_mpio(access, ranks.all(), MPI_INFO_NULL));
    const hid_t id = H5Fcreate(file.hidden().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
    refuse(id >= 0);
    write_all(ranks, ordered, id);
    refuse(H5Fclose(id) >= 0);
}

#else

bool has_grid_files() { return false; }

void write_grid(Ranks&, const OrderedMesh&, const SharedFile&) { throw InternalError("there is no HDF5"); }

#endif

}  // namespace vcell::mpi
