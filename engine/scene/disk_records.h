#pragma once
// The records of world.fbs and the structs of static_scene.h, one into the other. Records have no bytes that are not
// written, so packs are the same byte for byte.

#include "engine/scene/static_scene.h"
#include "engine/scene/walk.h"
#include "engine/scene/world.h"
#include "engine/scene/world_generated.h"

namespace ff::scene {

inline disk::Vec3 to_disk(const Vec3& v) {
    return {v.x, v.y, v.z};
}
inline disk::DVec3 to_disk(const DVec3& v) {
    return {v.x, v.y, v.z};
}
inline disk::Box3 to_disk(const Box3& b) {
    return {to_disk(b.low), to_disk(b.high)};
}
inline disk::DBox3 to_disk(const DBox3& b) {
    return {to_disk(b.low), to_disk(b.high)};
}
inline disk::Mat3 to_disk(const Mat3& m) {
    return {to_disk(m[0]), to_disk(m[1]), to_disk(m[2])};
}
inline disk::Mesh to_disk(const Mesh& m) {
    return {m.first_vertex, m.vertex_count, m.first_triangle, m.triangle_count,  m.first_node,
            m.node_count,   m.first_leaf,   m.leaf_count,     to_disk(m.bounds), m.material_flags};
}
inline disk::Instance to_disk(const Instance& i) {
    return {to_disk(i.position), to_disk(i.bounds), to_disk(i.world_from_mesh), i.mesh, i.cell};
}
inline disk::Cell to_disk(const Cell& c) {
    return {to_disk(c.origin), to_disk(c.bounds), c.triangle_count, c.first_instance, c.instance_count};
}
inline disk::Material to_disk(const Material& m) {
    return {to_disk(Vec3(m.base_color)),
            m.base_color.w,
            to_disk(m.emissive),
            m.alpha_cutoff,
            m.metallic,
            m.roughness,
            m.base_color_texture,
            m.emissive_texture,
            m.metallic_roughness_texture,
            m.flags};
}
inline disk::Texture to_disk(const Texture& t) {
    return {t.first_texel, t.width, t.height, t.level_count, std::uint8_t(t.wrap_u), std::uint8_t(t.wrap_v)};
}
inline disk::HeightGrid to_disk(const HeightGrid& g) {
    return {g.low_x, g.low_z, g.square_m, g.base_y, g.size};
}
inline disk::SoundSource to_disk(const SoundSource& s) {
    return {to_disk(s.position), s.clip, s.reference_m, s.gain};
}
inline disk::MovingModel to_disk(const MovingModel& m) {
    return {to_disk(m.position), m.yaw, m.first_instance, m.instance_count, m.first_animated, m.animated_count};
}
inline disk::Flock to_disk(const Flock& f) {
    return {to_disk(f.model), f.birds, f.radius_m};
}
inline disk::LooseBody to_disk(const LooseBody& b) {
    return {to_disk(b.model), b.mass_kg};
}
inline disk::Lamp to_disk(const Lamp& l) {
    return {to_disk(l.position), to_disk(l.color), l.lumens, l.radius_m, l.on_below_sun_deg};
}
inline disk::Environment to_disk(const Environment& e) {
    return {to_disk(e.to_sun),        to_disk(e.sun_radiance), to_disk(e.sky_zenith), to_disk(e.sky_horizon),
            to_disk(e.ground_bounce), e.fog_density_per_m,     e.panorama_width,      e.panorama_height};
}
inline disk::DynamicInstance to_disk(const DynamicInstance& i) {
    return {to_disk(i.position), to_disk(i.world_from_mesh), i.mesh};
}
inline disk::WalkFrame to_disk(const WalkFrame& f) {
    return {to_disk(f.position), f.yaw_deg, f.pitch_deg, f.roll_deg};
}

inline Vec3 from_disk(const disk::Vec3& v) {
    return {v.x(), v.y(), v.z()};
}
inline DVec3 from_disk(const disk::DVec3& v) {
    return {v.x(), v.y(), v.z()};
}
inline Box3 from_disk(const disk::Box3& b) {
    return {from_disk(b.low()), from_disk(b.high())};
}
inline DBox3 from_disk(const disk::DBox3& b) {
    return {from_disk(b.low()), from_disk(b.high())};
}
inline Mat3 from_disk(const disk::Mat3& m) {
    return {from_disk(m.column_x()), from_disk(m.column_y()), from_disk(m.column_z())};
}
inline Mesh from_disk(const disk::Mesh& m) {
    return {.first_vertex = m.first_vertex(),
            .vertex_count = m.vertex_count(),
            .first_triangle = m.first_triangle(),
            .triangle_count = m.triangle_count(),
            .first_node = m.first_node(),
            .node_count = m.node_count(),
            .first_leaf = m.first_leaf(),
            .leaf_count = m.leaf_count(),
            .bounds = from_disk(m.bounds()),
            .material_flags = m.material_flags()};
}
inline Instance from_disk(const disk::Instance& i) {
    return {.position = from_disk(i.position()),
            .world_from_mesh = from_disk(i.world_from_mesh()),
            .mesh = i.mesh(),
            .cell = i.cell(),
            .bounds = from_disk(i.bounds())};
}
inline Cell from_disk(const disk::Cell& c) {
    return {.origin = from_disk(c.origin()),
            .bounds = from_disk(c.bounds()),
            .first_instance = c.first_instance(),
            .instance_count = c.instance_count(),
            .triangle_count = c.triangle_count()};
}
inline Material from_disk(const disk::Material& m) {
    return {.base_color = Vec4(from_disk(m.base_color()), m.base_alpha()),
            .emissive = from_disk(m.emissive()),
            .alpha_cutoff = m.alpha_cutoff(),
            .metallic = m.metallic(),
            .roughness = m.roughness(),
            .base_color_texture = m.base_color_texture(),
            .emissive_texture = m.emissive_texture(),
            .metallic_roughness_texture = m.metallic_roughness_texture(),
            .flags = m.flags()};
}
inline Texture from_disk(const disk::Texture& t) {
    return {.width = t.width(),
            .height = t.height(),
            .level_count = t.level_count(),
            .wrap_u = Wrap(t.wrap_u()),
            .wrap_v = Wrap(t.wrap_v()),
            .first_texel = t.first_texel()};
}
inline HeightGrid from_disk(const disk::HeightGrid& g) {
    return {.size = g.size(), .low_x = g.low_x(), .low_z = g.low_z(), .square_m = g.square_m(), .base_y = g.base_y()};
}
inline SoundSource from_disk(const disk::SoundSource& s) {
    return {.position = from_disk(s.position()), .clip = s.clip(), .reference_m = s.reference_m(), .gain = s.gain()};
}
inline MovingModel from_disk(const disk::MovingModel& m) {
    return {.position = from_disk(m.position()),
            .yaw = m.yaw(),
            .first_instance = m.first_instance(),
            .instance_count = m.instance_count(),
            .first_animated = m.first_animated(),
            .animated_count = m.animated_count()};
}
inline Flock from_disk(const disk::Flock& f) {
    return {.model = from_disk(f.model()), .birds = f.birds(), .radius_m = f.radius_m()};
}
inline LooseBody from_disk(const disk::LooseBody& b) {
    return {.model = from_disk(b.model()), .mass_kg = b.mass_kg()};
}
inline Lamp from_disk(const disk::Lamp& l) {
    return {.position = from_disk(l.position()),
            .color = from_disk(l.color()),
            .lumens = l.lumens(),
            .radius_m = l.radius_m(),
            .on_below_sun_deg = l.on_below_sun_deg()};
}
inline Environment from_disk(const disk::Environment& e) {
    return {.to_sun = from_disk(e.to_sun()),
            .sun_radiance = from_disk(e.sun_radiance()),
            .sky_zenith = from_disk(e.sky_zenith()),
            .sky_horizon = from_disk(e.sky_horizon()),
            .ground_bounce = from_disk(e.ground_bounce()),
            .fog_density_per_m = e.fog_density_per_m(),
            .panorama_width = e.panorama_width(),
            .panorama_height = e.panorama_height()};
}
inline DynamicInstance from_disk(const disk::DynamicInstance& i) {
    return {i.mesh(), from_disk(i.position()), from_disk(i.world_from_mesh())};
}
inline WalkFrame from_disk(const disk::WalkFrame& f) {
    return {from_disk(f.position()), f.yaw_deg(), f.pitch_deg(), f.roll_deg()};
}

}  // namespace ff::scene
