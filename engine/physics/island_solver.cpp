#include "engine/physics/island_solver.h"

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAlignedObjectArray.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::physics {
namespace {

btVector3 to_bullet(const Vec3& v) {
    return {v.x, v.y, v.z};
}
Vec3 from_bullet(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}

/// Gives out objects in the order they are asked for, again after reset(); never frees.
template <class T>
class Pool {
  public:
    template <class Make>
    T& take(Make&& make) {
        if (used_ == all_.size()) all_.push_back(make());
        return *all_[used_++];
    }
    void reset() { used_ = 0; }

  private:
    std::vector<std::unique_ptr<T>> all_;
    std::size_t used_ = 0;
};

}  // namespace

struct IslandSolver::Impl {
    btSequentialImpulseConstraintSolver solver;
    btContactSolverInfo info;
    btRigidBody scene{btRigidBody::btRigidBodyConstructionInfo(0.0f, nullptr, nullptr)};
    Pool<btRigidBody> bodies;
    Pool<btPersistentManifold> manifolds;
    std::vector<btRigidBody*> of_body;  ///< by place in the step's bodies; null: not in this island
    std::vector<std::uint32_t> used;    ///< places that are not null
    std::vector<btCollisionObject*> objects;
    std::vector<btPersistentManifold*> touched;

    btRigidBody& rigid_body(const SolverBody& body, std::uint32_t place, const DVec3& origin) {
        if (of_body[place] != nullptr) return *of_body[place];
        btRigidBody& out = bodies.take([] {
            return std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(1.0f, nullptr, nullptr));
        });
        const int flags =
            out.getCollisionFlags() & ~(btCollisionObject::CF_KINEMATIC_OBJECT | btCollisionObject::CF_STATIC_OBJECT);
        out.setMassProps(body.mass_kg, to_bullet(body.inertia));
        out.setCollisionFlags(body.mass_kg > 0.0f ? flags : flags | btCollisionObject::CF_KINEMATIC_OBJECT);
        btTransform at;
        at.setRotation(btQuaternion(body.rotation.x, body.rotation.y, body.rotation.z, body.rotation.w));
        at.setOrigin(to_bullet(Vec3(body.position - origin)));
        out.setWorldTransform(at);
        out.updateInertiaTensor();
        out.setLinearVelocity(to_bullet(body.velocity));
        out.setAngularVelocity(to_bullet(body.spin));
        out.clearForces();
        out.setCompanionId(-1);
        out.setWorldArrayIndex(int(used.size()));
        of_body[place] = &out;
        used.push_back(place);
        return out;
    }

    /// Contacts into manifolds of up to four points each, by where their normals look: the floor's points must not
    /// crowd out the wall's.
    void add_manifolds(const SolverPair& pair, std::span<const Contact> contacts, btRigidBody& a, btRigidBody& b) {
        constexpr float kSameWay = 0.9f;  // cosine
        constexpr std::size_t kMost = 6;
        const std::size_t first = touched.size();
        const btTransform &at_a = a.getWorldTransform(), &at_b = b.getWorldTransform();
        for (const Contact& contact : contacts.subspan(pair.first_contact, pair.contact_count)) {
            const btVector3 normal = to_bullet(contact.normal);
            btPersistentManifold* home = nullptr;
            for (std::size_t m = first; m < touched.size() && home == nullptr; ++m)
                if (touched[m]->getContactPoint(0).m_normalWorldOnB.dot(normal) > kSameWay) home = touched[m];
            if (home == nullptr) {
                if (touched.size() - first == kMost) continue;
                home = &manifolds.take([] { return std::make_unique<btPersistentManifold>(); });
                home->clearManifold();
                home->setBodies(&a, &b);
                home->setContactBreakingThreshold(0.01f);
                home->setContactProcessingThreshold(1.0f);
                touched.push_back(home);
            }
            const btVector3 on_a = at_a.getOrigin() + to_bullet(contact.from_a);
            const btVector3 on_b = pair.b == SolverPair::kScene ? at_a.getOrigin() + to_bullet(contact.from_b)
                                                                : at_b.getOrigin() + to_bullet(contact.from_b);
            btManifoldPoint point(at_a.invXform(on_a), at_b.invXform(on_b), normal, contact.distance);
            point.m_positionWorldOnA = on_a;
            point.m_positionWorldOnB = on_b;
            point.m_combinedFriction = pair.friction;
            point.m_combinedRestitution = pair.restitution;
            point.m_combinedRollingFriction = point.m_combinedSpinningFriction = pair.rolling_m;
            const int same = home->getCacheEntry(point);
            if (same < 0)
                home->addManifoldPoint(point);
            else if (home->getContactPoint(same).m_distance1 > contact.distance)
                home->getContactPoint(same) = point;
        }
    }
};

IslandSolver::IslandSolver(double tick_s, int iterations) : iterations_(iterations), impl_(std::make_unique<Impl>()) {
    btContactSolverInfo& info = impl_->info;
    info.m_timeStep = btScalar(tick_s);
    info.m_solverMode = SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_splitImpulse = 1;
    info.m_splitImpulsePenetrationThreshold = 0.0f;  // depth is never turned into speed
    info.m_linearSlop = 0.001f;
    info.m_erp2 = 0.2f;
    info.m_restitutionVelocityThreshold = 0.5f;
}
IslandSolver::~IslandSolver() = default;

void IslandSolver::solve(std::span<SolverBody> bodies, std::span<const std::uint32_t> members,
                         std::span<const SolverPair> pairs, std::span<const Contact> contacts) {
    Impl& s = *impl_;
    s.bodies.reset();
    s.manifolds.reset();
    s.objects.clear();
    s.touched.clear();
    s.used.clear();
    s.of_body.resize(bodies.size(), nullptr);
    // A push has to get through the whole pile within the tick: what stands alone needs few, a stack many.
    constexpr int kMostFor = 16;
    s.info.m_numIterations = iterations_ + iterations_ / 3 * (std::min(int(members.size()), kMostFor) - 1);
    // Whole metres: what is the same but for where it stands comes out the same.
    const DVec3 origin = glm::floor(bodies[members.front()].position);

    for (const std::uint32_t place : members) s.objects.push_back(&s.rigid_body(bodies[place], place, origin));
    for (const SolverPair& pair : pairs) {
        btRigidBody& a = *s.of_body[pair.a];
        btRigidBody* b = &s.scene;
        if (pair.b != SolverPair::kScene) {
            const bool known = s.of_body[pair.b] != nullptr;
            b = &s.rigid_body(bodies[pair.b], pair.b, origin);
            if (!known) s.objects.push_back(b);
        }
        s.add_manifolds(pair, contacts, a, *b);
    }
    s.solver.solveGroup(s.objects.data(), int(s.objects.size()), s.touched.data(), int(s.touched.size()), nullptr, 0,
                        s.info, nullptr, nullptr);

    for (const std::uint32_t place : members) {
        SolverBody& body = bodies[place];
        const btRigidBody& solved = *s.of_body[place];
        body.velocity = from_bullet(solved.getLinearVelocity());
        body.spin = from_bullet(solved.getAngularVelocity());
        const btTransform& at = solved.getWorldTransform();
        btTransform before;
        before.setRotation(btQuaternion(body.rotation.x, body.rotation.y, body.rotation.z, body.rotation.w));
        body.shift = DVec3(from_bullet(at.getOrigin()) - Vec3(body.position - origin));
        body.turned = !(at.getBasis() == before.getBasis());
        if (body.turned) {
            const btQuaternion q = at.getRotation();
            body.rotation = glm::normalize(glm::quat(q.w(), q.x(), q.y(), q.z()));
        }
    }
    for (const std::uint32_t place : s.used) s.of_body[place] = nullptr;
}

}  // namespace ff::physics
