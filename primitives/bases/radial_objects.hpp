/// What becomes of a scene's objects over a sphere or a cylinder base before they have forms: vessels, too.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cone_form.hpp"
#include "radial_base.hpp"
#include "world_objects.hpp"

namespace vcell {

/// For the message about a plane that is not clear of the base's body.
const char* cuts_or_touches(Sign clearance);

/// Those of every kind, vessels included.
class RadialObjects : public WorldObjects {
public:
    using WorldObjects::WorldObjects;

    Listed<HollowSphere> hollow_balls;

    /// Leaves out what lies in other solids, cylinders beyond planes, and what lies beyond the wall of a
    /// vessel: never nearer than those, they may tie with them along whole curves of the base. `mirrored` are
    /// images of a base cylinder in sides of the box: on the side, base and image are equally far.
    void drop_hidden_and_equal(const std::vector<std::pair<CylinderForm, Site>>& mirrored);

    void warn(const FormSites& sites, std::vector<std::string>& warnings) const {
        WorldObjects::warn(sites, "out of sight of the base", warnings);
    }

private:
    void drop_wider_vessels();
};

/// The sites of each form, and the first one as an object.
struct FoundForms {
    std::vector<FormId> of_object;
    FormSites sites;
    IdVector<FormId, Object> objects;

    explicit FoundForms(const Scene& scene) : of_object(scene.objects.size()), scene_(scene) {
        sites.reserve(of_object.size() + 6);
        objects.reserve(of_object.size() + 6);
    }
    void add(Site site, const Object& canonical) { note(site, add_one_of(site, canonical)); }
    /// Likewise of an object that has several forms; add_twins() knows nothing of these.
    FormId add_one_of(Site site, const Object& canonical) {
        objects.push_back(canonical);
        return sites.add(site);
    }
    void join(Site site, FormId f) {
        sites.join(f, site);
        note(site, f);
    }
    /// The sites of objects that have another one's form.
    void add_twins(const RadialObjects& all);

private:
    void note(Site site, FormId f) {
        if (site.is_object()) of_object[scene_.place(site.index)] = f;
    }

    const Scene& scene_;
};

}  // namespace vcell
