// Everything that lives, as bytes. Little-endian, no padding: what is equal has equal bytes.

#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "engine/physics/numbers.h"
#include "engine/physics/physics_impl.h"

namespace ff::physics {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint32_t kMagic = 0x50464646;  // "FFFP"
constexpr std::uint32_t kVersion = 1;

/// One thing's bytes, for its hash; no memory is asked for.
struct Record {
    std::array<std::byte, 512> bytes;
    std::size_t size = 0;

    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        FF_CHECK(size + sizeof(T) <= bytes.size(), "a record of more than {} bytes", bytes.size());
        std::memcpy(bytes.data() + size, &value, sizeof(T));
        size += sizeof(T);
    }
    [[nodiscard]] std::uint64_t hash(std::uint64_t seed) const {
        return hash_bytes(std::span(bytes).first(size), seed);
    }
};

/// Writes what it is shown.
struct Writer {
    std::vector<std::byte>& out;

    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
        out.insert(out.end(), bytes, bytes + sizeof(T));
    }
};

/// Reads into what it is shown; past the end it reads zeros and says so.
struct Reader {
    std::span<const std::byte> in;
    std::size_t at = 0;
    bool complete = true;

    template <class T>
    void operator()(T& value) {
        static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
        if constexpr (std::is_same_v<T, bool>) {
            std::uint8_t byte = 0;
            (*this)(byte);
            complete = complete && byte <= 1;
            value = byte == 1;
        } else {
            if (in.size() - at < sizeof(T)) {
                complete = false;
                value = T{};
                return;
            }
            std::memcpy(&value, in.data() + at, sizeof(T));
            at += sizeof(T);
        }
    }
};

// Each kind of thing is listed once, for both ways: Value is const for the writer.

template <class Archive, class Vector>
void vector(Archive& archive, Vector& v) {
    archive(v.x), archive(v.y), archive(v.z);
}
template <class Archive, class Matrix>
void matrix(Archive& archive, Matrix& m) {
    for (int column = 0; column < 3; ++column) vector(archive, m[column]);
}
template <class Archive, class Quat>
void rotation(Archive& archive, Quat& q) {
    archive(q.w), archive(q.x), archive(q.y), archive(q.z);
}
template <class Archive, class Value>
void frame(Archive& archive, Value& f) {
    vector(archive, f.position);
    rotation(archive, f.rotation);
}
template <class Archive, class Id>
void id(Archive& archive, Id& i) {
    archive(i.index), archive(i.generation);
}

template <class Archive, class Value>
void body_record(Archive& archive, Value& b) {
    archive(b.generation), archive(b.alive);
    if (!b.alive) return;
    auto& d = b.desc;
    archive(d.shape.kind);
    vector(archive, d.shape.half_extents_m);
    archive(d.shape.radius_m), archive(d.shape.half_height_m), archive(d.shape.mesh);
    matrix(archive, d.shape.body_from_mesh);
    archive(d.motion), archive(d.mass_kg), archive(d.friction), archive(d.restitution);
    archive(d.rolling_resistance), archive(d.linear_damping), archive(d.angular_damping), archive(d.user);
    frame(archive, b.frame);
    frame(archive, b.before);
    frame(archive, b.target);
    archive(b.has_target);
    vector(archive, b.velocity);
    vector(archive, b.spin);
    archive(b.asleep), archive(b.still_s);
}

template <class Archive, class Value>
void character_record(Archive& archive, Value& c) {
    archive(c.generation), archive(c.alive);
    if (!c.alive) return;
    auto& d = c.desc;
    archive(d.radius_m), archive(d.height_m), archive(d.crouch_height_m), archive(d.step_height_m);
    archive(d.max_slope_rad), archive(d.gravity_m_s2), archive(d.jump_height_m), archive(d.ground_accel_m_s2);
    archive(d.air_accel_m_s2), archive(d.max_fall_m_s), archive(d.push_force_n), archive(d.mass_kg), archive(d.user);
    vector(archive, c.input.velocity_m_s);
    archive(c.input.jump), archive(c.input.crouch);
    vector(archive, c.feet);
    vector(archive, c.velocity);
    vector(archive, c.ground_normal);
    id(archive, c.ground);
    archive(c.on_ground), archive(c.crouching);
}

template <class Archive, class Value>
void settings_of(Archive& archive, Value& s) {
    archive(s.tick_s);
    vector(archive, s.gravity_m_s2);
    archive(s.solver_iterations), archive(s.active_range_m);
}

Error damaged(std::size_t at, const char* what) {
    return bad_input(fmt::format("physics state@0x{:x}: {}; the state is damaged, use an earlier one", at, what));
}

Status check_frame(const Frame& f) {
    FF_TRY(check_vector("position", f.position, 2.0 * kMaxCoordinate_m));
    return check_range("squared length of rotation", double(glm::dot(f.rotation, f.rotation)), 0.99, 1.01);
}

/// What a read body may hold: as add_body would take it, and as steps leave it.
Status check_read(const Body& b) {
    BodyDesc desc = b.desc;
    FF_TRY(check_body(desc));
    FF_TRY(check_frame(b.frame));
    FF_TRY(check_frame(b.before));
    FF_TRY(check_frame(b.target));
    FF_TRY(check_vector("velocity", b.velocity, 1e12));
    FF_TRY(check_vector("spin", b.spin, 1e12));
    return check_range("time at rest", b.still_s, 0.0, 1e9);
}
Status check_read(const Character& c) {
    CharacterDesc desc = c.desc;
    FF_TRY(check_character(desc));
    FF_TRY(check_input(c.input));
    FF_TRY(check_vector("feet", c.feet, 2.0 * kMaxCoordinate_m));
    FF_TRY(check_vector("velocity", c.velocity, 1e12));
    return check_vector("ground normal", c.ground_normal, 1.1);
}

/// The slots that are free, each once.
bool is_free_list(std::span<const std::uint32_t> list, std::size_t slots, auto&& is_alive) {
    std::vector<bool> seen(slots, false);
    std::size_t dead = 0;
    for (std::size_t slot = 0; slot < slots; ++slot) dead += is_alive(slot) ? 0 : 1;
    for (const std::uint32_t slot : list) {
        if (slot >= slots || is_alive(slot) || seen[slot]) return false;
        seen[slot] = true;
    }
    return dead == list.size();
}

}  // namespace

std::vector<std::byte> PhysicsWorld::state() const {
    const Impl& s = *impl_;
    std::vector<std::byte> out;
    Writer write{out};
    write(kMagic), write(kVersion);
    settings_of(write, s.settings);
    write(s.tick);
    write(std::uint32_t(s.bodies.slot_count()));
    for (std::uint32_t slot = 0; slot < s.bodies.slot_count(); ++slot) body_record(write, s.bodies[slot]);
    write(std::uint32_t(s.bodies.free_slots().size()));
    for (const std::uint32_t slot : s.bodies.free_slots()) write(slot);
    write(std::uint32_t(s.characters.size()));
    for (const Character& c : s.characters) character_record(write, c);
    write(std::uint32_t(s.free_characters.size()));
    for (const std::uint32_t slot : s.free_characters) write(slot);
    return out;
}

Status PhysicsWorld::set_state(std::span<const std::byte> bytes) {
    Impl& s = *impl_;
    Reader read{bytes};
    std::uint32_t magic = 0, version = 0, count = 0;
    read(magic), read(version);
    if (magic != kMagic) return damaged(0, "does not begin as one");
    if (version != kVersion)
        return bad_input(fmt::format("physics state v{}; this build reads v{}", version, kVersion));
    PhysicsSettings settings;
    settings_of(read, settings);
    std::vector<std::byte> mine, its;
    Writer write_mine{mine}, write_its{its};
    settings_of(write_mine, s.settings);
    settings_of(write_its, settings);
    if (mine != its) return bad_input("physics state of other settings; expected those of this world");
    std::uint64_t tick = 0;
    read(tick);

    // Nothing is made for a count that the bytes cannot hold.
    const auto fits = [&](std::size_t bytes_each) {
        return read.complete && count <= (bytes.size() - read.at) / bytes_each;
    };
    std::vector<Body> bodies;
    read(count);
    if (!fits(5)) return damaged(read.at, "more bodies than bytes");
    bodies.resize(count);
    for (Body& b : bodies) {
        const std::size_t at = read.at;
        body_record(read, b);
        if (b.generation == 0) return damaged(at, "a body without a generation");
        if (!b.alive) continue;
        if (const Status problem = check_read(b); !problem) return damaged(at, problem.error().message.c_str());
        auto geometry = s.bodies.geometry_of(b.desc.shape);
        if (!geometry) return damaged(at, geometry.error().message.c_str());
        b.geometry = std::move(*geometry);
    }
    std::vector<std::uint32_t> free_bodies;
    read(count);
    if (!fits(4)) return damaged(read.at, "more free slots than bytes");
    free_bodies.resize(count);
    for (std::uint32_t& slot : free_bodies) read(slot);
    if (!is_free_list(free_bodies, bodies.size(), [&](std::size_t i) { return bodies[i].alive; }))
        return damaged(read.at, "free slots that are not the bodies'");

    std::vector<Character> characters;
    read(count);
    if (!fits(5)) return damaged(read.at, "more characters than bytes");
    characters.resize(count);
    for (Character& c : characters) {
        const std::size_t at = read.at;
        character_record(read, c);
        if (c.generation == 0) return damaged(at, "a character without a generation");
        if (!c.alive) continue;
        if (const Status problem = check_read(c); !problem) return damaged(at, problem.error().message.c_str());
        if (const Status problem = s.give_shapes(c); !problem) return damaged(at, problem.error().message.c_str());
    }
    std::vector<std::uint32_t> free_characters;
    read(count);
    if (!fits(4)) return damaged(read.at, "more free slots than bytes");
    free_characters.resize(count);
    for (std::uint32_t& slot : free_characters) read(slot);
    if (!is_free_list(free_characters, characters.size(), [&](std::size_t i) { return characters[i].alive; }))
        return damaged(read.at, "free slots that are not the characters'");
    if (!read.complete || read.at != bytes.size()) return damaged(read.at, "its length is not what it says");

    s.tick = tick;
    s.bodies.restore(std::move(bodies), std::move(free_bodies));
    s.characters = std::move(characters);
    s.free_characters = std::move(free_characters);
    s.moved.clear();
    s.list_bodies();
    return {};
}

std::uint64_t PhysicsWorld::Impl::hash_of(std::uint32_t slot) const {
    Record record;
    body_record(record, bodies[slot]);
    return record.hash(slot);
}

// A hash of what moves, and a sum over what sleeps that is kept from tick to tick: a world of sleepers is as cheap as
// an empty one.
std::uint64_t PhysicsWorld::hash() const {
    const Impl& s = *impl_;
    Record head;
    settings_of(head, s.settings);
    head(s.tick), head(s.asleep_sum), head(s.asleep_count);
    head(s.bodies.slot_count()), head(s.characters.size());
    std::uint64_t hash = head.hash(kVersion);
    for (const auto* const list : {&s.awake, &s.kinematic}) {
        for (const std::uint32_t slot : *list) {
            Record record;
            body_record(record, s.bodies[slot]);
            hash = record.hash(hash + slot);
        }
    }
    for (const std::uint32_t slot : s.bodies.free_slots()) {
        Record record;
        record(slot), record(s.bodies[slot].generation);
        hash = record.hash(hash);
    }
    for (const Character& c : s.characters) {
        Record record;
        character_record(record, c);
        hash = record.hash(hash);
    }
    return hash_bytes(std::as_bytes(std::span(s.free_characters)), hash);
}

}  // namespace ff::physics
