#include "mesh_letters.hpp"

#include <memory>

namespace vcell::mpi {

namespace {

using shared::SharedFace;
using shared::SharedLine;
using shared::SharedPoint;
using shared::SharedVertex;

void put(Letter& letter, const SharedPoint& p) {
    letter.put(p.id);
    letter.put(p.image);
    letter.put(p.unmoved_place);
}
SharedPoint get_point(LetterReader& in) {
    const auto id = in.get<shared::SharedId>();
    const auto image = in.get<shared::Image>();
    return {id, image, in.get<Vec3>()};
}

void put(Letter& letter, const std::vector<SharedPoint>& points) {
    letter.put(static_cast<std::uint64_t>(points.size()));
    for (const SharedPoint& p : points) put(letter, p);
}
std::vector<SharedPoint> get_points(LetterReader& in) {
    std::vector<SharedPoint> points;
    for (auto left = in.get<std::uint64_t>(); left > 0; --left) points.push_back(get_point(in));
    return points;
}

void put(Letter& letter, const SharedLine& line) {
    letter.put(line.id);
    put(letter, line.points);
    letter.put(line.inner);
    letter.put(line.sites);
    letter.put(line.is_closed);
    letter.put(line.error);
}
std::shared_ptr<SharedLine> get_line(LetterReader& in) {
    auto line = std::make_shared<SharedLine>();
    line->id = in.get<shared::SharedId>();
    line->points = get_points(in);
    line->inner = in.get<Vec3>();
    line->sites = in.list<NetworkSite>();
    line->is_closed = in.get<bool>();
    line->error = in.get<double>();
    return line;
}

void put(Letter& letter, const SharedVertex& vertex);
void put(Letter& letter, const SharedFace& face);

template <class T>
void put_all(Letter& letter, const std::vector<std::shared_ptr<T>>& all) {
    letter.put(static_cast<std::uint64_t>(all.size()));
    for (const auto& one : all) put(letter, *one);
}
template <class T>
void get_all(LetterReader& in, std::shared_ptr<T> (*get)(LetterReader&),
             std::vector<std::shared_ptr<T>>& all) {
    for (auto left = in.get<std::uint64_t>(); left > 0; --left) all.push_back(get(in));
}

void put(Letter& letter, const SharedVertex& vertex) {
    put(letter, vertex.point);
    letter.put(vertex.sites);
    letter.put(vertex.error);
    letter.put(vertex.is_touching);
    put_all(letter, vertex.lines);
}
std::shared_ptr<SharedVertex> get_vertex(LetterReader& in) {
    auto vertex = std::make_shared<SharedVertex>();
    vertex->point = get_point(in);
    vertex->sites = in.list<NetworkSite>();
    vertex->error = in.get<double>();
    vertex->is_touching = in.get<bool>();
    get_all(in, get_line, vertex->lines);
    return vertex;
}

void put(Letter& letter, const SharedFace& face) {
    letter.put(face.owner);
    letter.put(face.beyond);
    letter.put(face.border);
    put(letter, face.points);
    letter.put(face.triangles);
    letter.put(face.normals);
    letter.put(face.corner_normals);
    letter.put(face.across);
}
std::shared_ptr<SharedFace> get_face(LetterReader& in) {
    auto face = std::make_shared<SharedFace>();
    face->owner = in.get<std::uint32_t>();
    face->beyond = in.get<NetworkSite>();
    face->border = in.list<shared::BorderLine>();
    face->points = get_points(in);
    face->triangles = in.list<Triangle>();
    face->normals = in.list<Vec3>();
    face->corner_normals = in.list<Triangle>();
    face->across = in.list<MeshSide>();
    return face;
}

}  // namespace

void put_additions(Letter& letter, const shared::Additions& additions) {
    letter.put(additions.object);
    put_all(letter, additions.vertices);
    put_all(letter, additions.closed_lines);
    put_all(letter, additions.faces);
}

shared::Additions get_additions(LetterReader& in) {
    shared::Additions additions;
    additions.object = in.get<std::uint32_t>();
    get_all(in, get_vertex, additions.vertices);
    get_all(in, get_line, additions.closed_lines);
    get_all(in, get_face, additions.faces);
    return additions;
}

}  // namespace vcell::mpi
