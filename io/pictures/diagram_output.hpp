/// A whole diagram in files of any format, told by their endings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../../envelope/voronoi_diagram.hpp"

namespace vcell {

struct DiagramFileOptions {
    /// Meshes: ConformingMeshes' chord, a part of a cell's diagonal.
    double chord = 0.002;
    /// The plane of a .svg, across axis 0, 1 or 2 of the world.
    struct Cut {
        int axis;
        double at;
    };
    std::optional<Cut> cut;
    /// Where the meshes of all cells together would have more triangles, the chord grows until they do not
    /// (FittingChord). Then all cells are computed twice, to count before any is written, or where the chord
    /// does not fit, three times. None: there is no bound.
    std::optional<std::size_t> most_triangles;
};

/// Files that are written while a diagram is computed, cell by cell: .json (DiagramWriter), .step or .stp
/// (DiagramStep), .itd (DiagramItd), .bezier.vtu (BezierElements), .html (DiagramPage), .svg (DiagramCut),
/// .obj with materials in an .mtl beside it (DiagramObj), and .stl, .ply, .vtu, .glb and .3mf (LabelledMesh).
/// All that are made of triangles share one mesh of each cell (ConformingMeshes).
class DiagramFiles {
public:
    /// Creates the files (OutputFile). Throws std::invalid_argument for other endings, for a path that is
    /// given twice, for a .svg without a cut, and for .html where three.js was missing when vcell was built;
    /// WriteError.
    explicit DiagramFiles(const std::vector<std::string>& paths, const DiagramFileOptions& options = {});
    ~DiagramFiles();
    DiagramFiles(const DiagramFiles&) = delete;
    DiagramFiles& operator=(const DiagramFiles&) = delete;

    /// The paths, and those of materials.
    std::vector<std::string> targets() const;

    /// voronoi_diagram(), whose cells are written to the files; planes and tubes have complete cells there
    /// (DiagramOptions::complete, if there is a file). `options.visit` sees the cells, too. To be called
    /// once. Throws as voronoi_diagram() and the formats' own functions; TooManyTriangles where cells' edges
    /// alone ask for more than `most_triangles`.
    VoronoiDiagram compute(const DiagramScene& scene, DiagramOptions options = {});

    /// What the meshes of all cells have come to.
    struct MeshSize {
        double chord = 0;  ///< larger than asked for where that takes more than `most_triangles`
        std::size_t triangles = 0;
    };
    /// None where no file is made of triangles.
    const std::optional<MeshSize>& mesh_size() const { return mesh_size_; }

    /// Computed cells that have measures and no faces, so that they are in no file.
    const std::vector<std::uint32_t>& without_faces() const { return without_faces_; }

    /// All bytes have reached the files. Throws WriteError.
    void close();
    /// Closes them all, and gives them their names. Throws WriteError.
    void commit();

private:
    class One;
    bool has_triangles() const;
    double fitting_chord(const DiagramScene& scene, const DiagramOptions& options) const;
    static constexpr double counted_ = 2.0 / 3;  // so much of the work is done when the chord is known

    std::vector<std::unique_ptr<One>> files_;
    const double chord_;
    const std::optional<std::size_t> most_triangles_;
    std::optional<MeshSize> mesh_size_;
    std::vector<std::uint32_t> without_faces_;
};

}  // namespace vcell
