#include "surroundings.hpp"

#include <algorithm>
#include <utility>

#include "../core/threads.hpp"

namespace vcell::mpi {

namespace {

using whole::DecidedDiagram;
using whole::ImageTree;

enum class Kind : std::uint8_t { Nearest, Shell, Touching };
constexpr std::uint32_t nobody = UINT32_MAX;  // is left out of a search

void put_known(Letter& letter, std::uint32_t number, const Object& object, const std::string& name) {
    letter.put(number);
    letter.put(object);
    letter.put(name);
}

KnownObject get_known(LetterReader& in) {
    KnownObject known;
    known.number = in.get<std::uint32_t>();
    known.object = in.get<Object>();
    known.name = in.get<std::string>();
    return known;
}

void put_marks(Letter& letter, const std::vector<SphereMarks::Mark>& marks) {
    letter.put(static_cast<std::uint64_t>(marks.size()));
    for (const SphereMarks::Mark& m : marks) {
        letter.put(m.p);
        letter.put(m.level);
    }
}
std::vector<SphereMarks::Mark> get_marks(LetterReader& in) {
    std::vector<SphereMarks::Mark> marks(in.get<std::uint64_t>());
    for (SphereMarks::Mark& m : marks) {
        m.p = in.get<Vec3>();
        m.level = in.get<double>();
    }
    return marks;
}

void put_search(Letter& letter, const whole::BallSearch& search) {
    letter.put(search.from);
    letter.put(search.to);
    letter.put(search.marks.has_value());
    if (!search.marks) return;
    const whole::PlacedMarks& placed = *search.marks;
    put_marks(letter, placed.marks.places);
    put_marks(letter, placed.marks.gradients);
    letter.put(placed.marks.steepest);
    letter.put(placed.marks.are_all);
    for (int k = 0; k < 3; ++k) letter.put(Vec3(placed.turn.col(k)));
    letter.put(placed.unit);
}
whole::BallSearch get_search(LetterReader& in) {
    whole::BallSearch search;
    search.from = in.get<double>();
    search.to = in.get<double>();
    if (!in.get<bool>()) return search;
    whole::PlacedMarks& placed = search.marks.emplace();
    placed.marks.places = get_marks(in);
    placed.marks.gradients = get_marks(in);
    placed.marks.steepest = in.get<double>();
    placed.marks.are_all = in.get<bool>();
    for (int k = 0; k < 3; ++k) placed.turn.col(k) = in.get<Vec3>();
    placed.unit = in.get<double>();
    return search;
}

// Calls visit(marks) with those that a search has, or otherwise(reach).
void with_search(const Sphere& base, const whole::BallSearch& search, auto&& visit, auto&& otherwise) {
    if (!search.marks) return otherwise(search.to);
    whole::CellMarks marks(base, *search.marks);
    marks.look_between(search.from, search.to);
    visit(marks);
}

}  // namespace

struct Surroundings::Question {
    int to;
    Letter letter;
};

Surroundings::Surroundings(Ranks& ranks, const SceneParts& parts, bool are_measured, unsigned threads)
    : ranks_(ranks),
      parts_(parts),
      threads_(threads),
      lattice_(parts.frame),
      are_sharing_(are_measured && parts.others.empty() && !parts.frame.probe) {
    const std::uint64_t before = ranks_.bytes_sent();
    hidden_.resize(parts_.own.size());
    is_large_.resize(parts_.own.size());
    sent_.resize(ranks_.size());
    learn_others();
    replicate_large_balls();
    find_hidden();
    forget_hidden();
    statistics_.replicated = known_.size();
    send_everything();
    settle();
    statistics_.bytes = ranks_.bytes_sent() - before;
}

void Surroundings::learn(KnownObject known, int from) {
    known_.emplace(known.number, Known{std::move(known), from});
}

void Surroundings::learn_others() {
    for (std::size_t k = 0; k < parts_.others.size(); ++k)
        learn(parts_.others[k], rank_of_other(k, ranks_.size()));
}

int Surroundings::owner(std::uint32_t number) const {
    const auto known = known_.find(number);
    return known != known_.end() ? known->second.from : ranks_.rank();
}

// A ball is large where blocks with it would reach far beyond their own centres, compared with other balls.
void Surroundings::replicate_large_balls() {
    double radii = 0;
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < parts_.own.size(); ++i)
        if (is_ball(i)) {
            radii += ball(i).radius;
            ++count;
        }
    const double all = static_cast<double>(std::max<std::uint64_t>(1, ranks_.sum(count)));
    constexpr double times = 8;
    const double large = times * ranks_.sum(radii) / all;
    Letter mine;
    for (std::size_t i = 0; i < parts_.own.size(); ++i)
        if (is_ball(i) && ball(i).radius > large) {
            is_large_[i] = true;
            put_known(mine, parts_.own[i].number, parts_.own[i].object, parts_.own[i].name);
        }
    learn_from(ranks_.share(mine));
}

// Offers the own balls that are neither large nor known to be hidden.
BlockMap Surroundings::block_map() const {
    BlockMap::Block mine;
    for (const BallTree::Entry& e : offered_.tree().entries())
        mine.largest = std::max(mine.largest, e.ball.radius);
    if (mine.largest >= 0) mine.centers = offered_.tree().centers();
    return {ranks_, lattice_, mine};
}

void Surroundings::find_hidden() {
    const auto offer = [&] {
        std::vector<BallTree::Entry> balls;
        for (std::uint32_t i = 0; i < parts_.own.size(); ++i)
            if (is_ball(i) && !is_large_[i] && hidden_[i].empty()) balls.push_back({ball(i), i});
        offered_ = ImageTree(lattice_, std::move(balls));
    };
    offer();
    blocks_ = block_map();
    // What holds a ball is in a block that comes deep into it.
    std::vector<Letter> asked(ranks_.size());
    for (std::size_t i = 0; i < parts_.own.size(); ++i)
        if (is_ball(i))
            blocks_.near(ball(i).center, whole::depth_in_holder(ball(i)),
                         [&](int rank) { asked[rank].put(ball(i)); });
    const std::vector<Letter> got = ranks_.exchange(std::move(asked));
    std::vector<Letter> told(ranks_.size());
    for (int rank = 0; rank < ranks_.size(); ++rank)
        for (LetterReader in(got[rank]); !in.at_end();) {
            const auto inner = in.get<Sphere>();
            offered_.within(inner.center, whole::depth_in_holder(inner),
                            [&](const Sphere& outer, std::uint32_t own, const whole::Image&) {
                                if (outer.radius >= inner.radius) put_ball(told[rank], rank, own);
                            });
        }
    learn_from(ranks_.exchange(std::move(told)));

    // Among these and all own balls, the large ones included.
    ranks_.together([&] {
        const whole::ScenePart part = known_part();
        std::vector<BallTree::Entry> balls;
        for (std::uint32_t i = 0; i < part.scene.objects.size(); ++i)
            if (const auto* ball = std::get_if<Sphere>(&part.scene.objects[i])) balls.push_back({*ball, i});
        const std::vector<std::string> hidden =
            whole::find_hidden(part.scene, part.numbers, ImageTree(lattice_, std::move(balls)));
        for (std::size_t i = 0; i < parts_.own.size(); ++i) hidden_[i] = hidden[places_[i]];
    });
    offer();
    blocks_ = block_map();
}

// Hidden balls are nowhere nearest: of others' only large ones that are not hidden stay known.
void Surroundings::forget_hidden() {
    for (auto& sent : sent_) sent.clear();
    known_.clear();
    learn_others();
    Letter mine;
    std::uint64_t balls = 0;
    for (std::size_t i = 0; i < parts_.own.size(); ++i) {
        if (!is_ball(i) || !hidden_[i].empty()) continue;
        ++balls;
        if (is_large_[i]) put_known(mine, parts_.own[i].number, parts_.own[i].object, parts_.own[i].name);
    }
    balls_ = ranks_.sum(balls);
    learn_from(ranks_.share(mine));
}

void Surroundings::learn_from(const std::vector<Letter>& letters) {
    for (std::size_t rank = 0; rank < letters.size(); ++rank)
        for (LetterReader in(letters[rank]); !in.at_end();) learn(get_known(in), static_cast<int>(rank));
}

void Surroundings::put_ball(Letter& letter, int to, std::size_t own) {
    if (!sent_[to].insert(static_cast<std::uint32_t>(own)).second) return;
    put_known(letter, parts_.own[own].number, parts_.own[own].object, parts_.own[own].name);
}

// Own objects and known ones, ascending.
whole::ScenePart Surroundings::known_part() {
    whole::ScenePart part;
    part.scene = parts_.frame;
    part.moved = parts_.moved;
    part.balls = balls_;
    places_.clear();
    const auto add = [&](std::uint32_t number, const Object& object, const std::string& name,
                         const std::string& hidden) {
        part.scene.objects.push_back(object);
        if (parts_.has_names) part.scene.names.push_back(name);
        part.numbers.push_back(number);
        part.hidden.push_back(hidden);
    };
    auto known = known_.begin();
    for (std::size_t i = 0; i < parts_.own.size(); ++i) {
        const OwnObject& own = parts_.own[i];
        for (; known != known_.end() && known->first <= own.number; ++known)
            if (known->first != own.number) add(known->first, known->second.object, known->second.name, "");
        places_.push_back(static_cast<std::uint32_t>(part.numbers.size()));
        add(own.number, own.object, own.name, hidden_[i]);
    }
    for (; known != known_.end(); ++known) add(known->first, known->second.object, known->second.name, "");
    return part;
}

void Surroundings::rebuild() {
    ranks_.together([&] { decided_.emplace(known_part()); });
}

void Surroundings::send_everything() {
    rebuild();
    for (std::size_t i = 0; i < parts_.own.size(); ++i)
        knows_everything_ = knows_everything_ || (hidden_[i].empty() && !decided_->is_wall(places_[i]) &&
                                                  !decided_->is_bounded(places_[i]));
    Letter mine;
    mine.put(knows_everything_);
    const std::vector<Letter> wishes = ranks_.share(mine);
    std::vector<Letter> told(ranks_.size());
    for (int rank = 0; rank < ranks_.size(); ++rank) {
        if (rank == ranks_.rank() || !LetterReader(wishes[rank]).get<bool>()) continue;
        for (const BallTree::Entry& e : offered_.tree().entries()) put_ball(told[rank], rank, e.number);
    }
    learn_from(ranks_.exchange(std::move(told)));
    rebuild();
}

// The questions of one cell, which takes the steps that it needs no answer for.
std::vector<Surroundings::Question> Surroundings::questions_of(std::size_t own) {
    std::vector<Question> questions;
    const Sphere& base = ball(own);
    DecidedDiagram::Competitors found;
    const auto find = [&](std::size_t count, Step asked) {
        found = decided_->competitors(places_[own], count);
        if (steps_[own] >= asked) return;
        steps_[own] = asked;
        blocks_.near(base.center, found.reach, [&](int rank) {
            Letter letter;
            letter.put(Kind::Nearest);
            letter.put(base.center);
            letter.put(found.reach);
            letter.put(static_cast<std::uint32_t>(count));
            questions.push_back({rank, std::move(letter)});
        });
    };
    find(DecidedDiagram::few, Step::Few);
    if (!questions.empty()) return questions;
    if (are_sharing_ && !is_searched_[own]) {
        search(own, questions);
        if (found_[own]) steps_[own] = Step::Certain;
        if (found_[own] || !questions.empty()) return questions;
    }
    DecidedDiagram::Bound bound = decided_->bound(base, found.nearest);
    if (bound.is_poor()) {
        find(DecidedDiagram::many, Step::Many);
        if (!questions.empty()) return questions;
        bound = decided_->bound(base, found.nearest);
    }
    steps_[own] = Step::Certain;
    blocks_.touching(bound.bound, [&](int rank) {
        Letter letter;
        letter.put(Kind::Touching);
        letter.put(base);
        letter.put(static_cast<std::uint32_t>(found.nearest.size()));
        for (const ImageTree::Found& f : found.nearest) {
            letter.put(f.ball);
            letter.put(f.distance);
        }
        questions.push_back({rank, std::move(letter)});
    });
    return questions;
}

// Tries to find a cell among what is known: the first of its searches that others may have an answer to is a
// question, and what comes of it is final where there is none.
void Surroundings::search(std::size_t own, std::vector<Question>& questions) {
    const Sphere& base = ball(own);
    std::vector<whole::BallSearch> searches;
    std::optional<whole::FoundCell> found = whole::common_ball_cell(*decided_, places_[own], searches);
    for (std::size_t& k = answered_[own]; k < searches.size() && questions.empty(); ++k) {
        const auto ask = [&](int rank) {
            Letter letter;
            letter.put(Kind::Shell);
            letter.put(base);
            put_search(letter, searches[k]);
            questions.push_back({rank, std::move(letter)});
        };
        with_search(
            base, searches[k], [&](const whole::CellMarks& marks) { blocks_.touching(marks, ask); },
            [&](double reach) { blocks_.near(base.center, reach, ask); });
    }
    if (!questions.empty()) return;
    is_searched_[own] = true;
    found_[own] = std::move(found);
}

// One round; returns the number of questions of all ranks.
std::uint64_t Surroundings::ask() {
    std::vector<std::vector<Question>> questions(parts_.own.size());
    ranks_.together([&] {
        for_all(parts_.own.size(), threads_, [&](std::size_t i) {
            if (steps_[i] != Step::Certain) questions[i] = questions_of(i);
        });
    });
    std::vector<Letter> asked(ranks_.size());
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < questions.size(); ++i) {
        if (!questions[i].empty() && !has_asked_[i]) {
            has_asked_[i] = true;
            ++statistics_.asking;
        }
        for (const Question& question : questions[i]) {
            asked[question.to].put(question.letter);
            ++count;
        }
    }
    statistics_.questions += count;
    const std::uint64_t all = ranks_.sum(count);
    if (all == 0) return 0;
    const std::vector<Letter> got = ranks_.exchange(std::move(asked));
    learn_from(ranks_.exchange(ranks_.together([&] { return answers(got); })));
    rebuild();
    return all;
}

std::vector<Letter> Surroundings::answers(const std::vector<Letter>& asked) {
    std::vector<Letter> told(asked.size());
    for (int rank = 0; rank < ranks_.size(); ++rank)
        for (LetterReader in(asked[rank]); !in.at_end();) {
            const auto put = [&](std::uint32_t own) { put_ball(told[rank], rank, own); };
            const auto kind = in.get<Kind>();
            if (kind == Kind::Nearest) {
                const auto center = in.get<Vec3>();
                const auto reach = in.get<double>();
                const auto count = in.get<std::uint32_t>();
                for (const ImageTree::Found& f : offered_.nearest(center, reach, count, nobody))
                    if (lattice_.repeats() || f.distance <= reach) put(f.number);
                continue;
            }
            const auto base = in.get<Sphere>();
            if (kind == Kind::Shell) {
                const auto visit = [&](const Sphere&, std::uint32_t own, const whole::Image&) { put(own); };
                with_search(
                    base, get_search(in),
                    [&](const whole::CellMarks& marks) { offered_.touching(marks, visit); },
                    [&](double reach) { offered_.within(base.center, reach, visit); });
                continue;
            }
            std::vector<ImageTree::Found> nearest(in.get<std::uint32_t>());
            for (ImageTree::Found& f : nearest) {
                f.ball = in.get<Sphere>();
                f.distance = in.get<double>();
            }
            offered_.touching(decided_->bound(base, nearest).bound,
                              [&](const Sphere&, std::uint32_t own, const whole::Image&) { put(own); });
        }
    return told;
}

void Surroundings::settle() {
    steps_.assign(parts_.own.size(), Step::Certain);
    has_asked_.assign(parts_.own.size(), false);
    is_searched_.assign(parts_.own.size(), false);
    found_.resize(parts_.own.size());
    answered_.assign(parts_.own.size(), 0);
    if (!knows_everything_)
        for (std::size_t i = 0; i < parts_.own.size(); ++i)
            if (is_ball(i) && hidden_[i].empty() && decided_->is_bounded(places_[i])) steps_[i] = Step::Begin;
    while (ask() > 0) ++statistics_.rounds;
    statistics_.ghosts = known_.size() - statistics_.replicated;
}

void Surroundings::settle_bounds(const std::vector<std::size_t>& own) {
    const std::uint64_t before = ranks_.bytes_sent();
    if (!knows_everything_)
        for (const std::size_t i : own) {
            is_searched_[i] = true;
            found_[i].reset();
            steps_[i] = Step::Few;
        }
    while (ask() > 0) ++statistics_.rounds;
    statistics_.ghosts = known_.size() - statistics_.replicated;
    statistics_.bytes += ranks_.bytes_sent() - before;
}

}  // namespace vcell::mpi
