#include "tools/cook/buildings_facade.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace ff::cook {

std::uint64_t hash_mix(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    // The finalizer of splitmix64 (Steele, Lea, Flood 2014) over each word in turn.
    std::uint64_t state = seed;
    for (const std::uint64_t word : {a, b, c}) {
        state += word * 0x9E3779B97F4A7C15ull + 0x9E3779B97F4A7C15ull;
        state = (state ^ (state >> 30)) * 0xBF58476D1CE4E5B9ull;
        state = (state ^ (state >> 27)) * 0x94D049BB133111EBull;
        state ^= state >> 31;
    }
    return state;
}

double hash_unit(std::uint64_t seed, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    return double(hash_mix(seed, a, b, c) >> 11) * 0x1.0p-53;
}

namespace {

/// The wall's own coordinates: s along it, y up, d outwards.
class FacadeWriter {
  public:
    FacadeWriter(MeshBuilder& mesh, const WallSpan& span, const FacadeStyle& style)
        : mesh_(mesh), style_(style), origin_(span.p), y0_(span.y0) {
        const DVec2 along = span.q - span.p;
        length_ = glm::length(along);
        along_ = along / length_;
        out_ = {along_.y, -along_.x};
    }
    [[nodiscard]] double length() const { return length_; }

    [[nodiscard]] DVec3 at(double s, double y, double d) const {
        return world_from_plan(origin_ + along_ * s + out_ * d, y);
    }
    /// Corners as (s, y, d), counter-clockwise seen from outside; textured by s and y (and d on flanks).
    void quad(const DVec3& a, const DVec3& b, const DVec3& c, const DVec3& d, std::uint32_t material,
              std::uint32_t color) {
        const auto uv = [&](const DVec3& p) {
            return Vec2((p.x + p.z) / style_.wall_tile_m.x, -(p.y - y0_ + p.z) / style_.wall_tile_m.y);
        };
        mesh_.flat_quad({at(a.x, a.y, a.z), at(b.x, b.y, b.z), at(c.x, c.y, c.z), at(d.x, d.y, d.z)},
                        {uv(a), uv(b), uv(c), uv(d)}, material, color);
    }
    void wall(double s0, double s1, double y0, double y1) {
        if (s1 - s0 < 1e-4 || y1 - y0 < 1e-4) return;
        quad({s0, y0, 0}, {s1, y0, 0}, {s1, y1, 0}, {s0, y1, 0}, style_.wall, style_.wall_color);
    }
    /// A box on the wall from depth d0 out to d1.
    void box(double s0, double s1, double y0, double y1, double d0, double d1, std::uint32_t material,
             std::uint32_t color, bool ends = true) {
        quad({s0, y0, d1}, {s1, y0, d1}, {s1, y1, d1}, {s0, y1, d1}, material, color);
        quad({s0, y1, d1}, {s1, y1, d1}, {s1, y1, d0}, {s0, y1, d0}, material, color);
        quad({s0, y0, d0}, {s1, y0, d0}, {s1, y0, d1}, {s0, y0, d1}, material, color);
        if (!ends) return;
        quad({s0, y0, d0}, {s0, y0, d1}, {s0, y1, d1}, {s0, y1, d0}, material, color);
        quad({s1, y0, d1}, {s1, y0, d0}, {s1, y1, d0}, {s1, y1, d1}, material, color);
    }
    /// A wall panel [s0, s1] x [y0, y1] with a hole [a0, a1] x [b0, b1], its reveals, and a pane at depth -recess.
    void opening(double s0, double s1, double y0, double y1, double a0, double a1, double b0, double b1, double recess,
                 std::uint32_t pane, std::uint32_t pane_color) {
        const std::uint32_t m = style_.wall, c = style_.wall_color;
        quad({s0, y0, 0}, {s1, y0, 0}, {a1, b0, 0}, {a0, b0, 0}, m, c);
        quad({s1, y0, 0}, {s1, y1, 0}, {a1, b1, 0}, {a1, b0, 0}, m, c);
        quad({s1, y1, 0}, {s0, y1, 0}, {a0, b1, 0}, {a1, b1, 0}, m, c);
        quad({s0, y1, 0}, {s0, y0, 0}, {a0, b0, 0}, {a0, b1, 0}, m, c);
        const double r = -recess;
        const std::uint32_t tm = style_.trim, tc = style_.trim_color;
        quad({a0, b0, 0}, {a1, b0, 0}, {a1, b0, r}, {a0, b0, r}, tm, tc);
        quad({a0, b1, r}, {a1, b1, r}, {a1, b1, 0}, {a0, b1, 0}, tm, tc);
        quad({a0, b0, r}, {a0, b1, r}, {a0, b1, 0}, {a0, b0, 0}, tm, tc);
        quad({a1, b0, 0}, {a1, b1, 0}, {a1, b1, r}, {a1, b0, r}, tm, tc);
        quad({a0, b0, r}, {a1, b0, r}, {a1, b1, r}, {a0, b1, r}, pane, pane_color);
    }

  private:
    MeshBuilder& mesh_;
    const FacadeStyle& style_;
    DVec2 origin_, along_{1.0, 0.0}, out_{0.0};
    double y0_, length_ = 0;
};

void add_window_trim(FacadeWriter& writer, const FacadeStyle& style, double a0, double a1, double b0, double b1) {
    const double r = style.recess_m;
    if (style.mullions) {
        const double middle = 0.5 * (a0 + a1), bar = 0.03, across = b0 + 0.66 * (b1 - b0);
        writer.box(middle - bar, middle + bar, b0, b1, -r, -r + 0.05, style.trim, style.trim_color);
        writer.box(a0, a1, across - bar, across + bar, -r, -r + 0.04, style.trim, style.trim_color, false);
    }
    if (style.sills) writer.box(a0 - 0.08, a1 + 0.08, b0 - 0.08, b0, 0, 0.14, style.trim, style.trim_color);
    if (style.frames) {
        writer.box(a0 - 0.12, a1 + 0.12, b1, b1 + 0.14, 0, 0.08, style.trim, style.trim_color);
        writer.box(a0 - 0.12, a0, b0, b1, 0, 0.06, style.trim, style.trim_color);
        writer.box(a1, a1 + 0.12, b0, b1, 0, 0.06, style.trim, style.trim_color);
    }
}

void add_balcony(FacadeWriter& writer, const FacadeStyle& style, double s0, double s1, double y) {
    const double depth = 1.1, rail = 1.0;
    writer.box(s0, s1, y - 0.16, y, 0, depth, style.trim, style.trim_color);
    writer.box(s0, s1, y + rail - 0.06, y + rail, depth - 0.06, depth, style.trim, style.trim_color);
    const int bars = std::max(2, int((s1 - s0) / 0.3));
    for (int i = 0; i <= bars; ++i) {
        const double s = s0 + (s1 - s0 - 0.04) * i / bars;
        writer.quad({s, y, depth - 0.03}, {s + 0.04, y, depth - 0.03}, {s + 0.04, y + rail, depth - 0.03},
                    {s, y + rail, depth - 0.03}, style.trim, style.trim_color);
    }
    for (const double s : {s0, s1 - 0.05})
        writer.box(s, s + 0.05, y, y + rail, 0, depth, style.trim, style.trim_color, true);
}

}  // namespace

void add_blank_wall(MeshBuilder& mesh, const WallSpan& span, const FacadeStyle& style) {
    if (span.y1 - span.y0 < 1e-3 || glm::length(span.q - span.p) < 1e-3) return;
    FacadeWriter writer(mesh, span, style);
    writer.wall(0, writer.length(), span.y0, span.y1);
}

void add_facade(MeshBuilder& mesh, const WallSpan& span, const FacadeStyle& style, std::uint64_t seed, bool door) {
    const double length = glm::length(span.q - span.p);
    const double height = span.y1 - span.ground_y;
    if (length < 2.0 || height < 2.4) {
        add_blank_wall(mesh, span, style);
        return;
    }
    FacadeWriter writer(mesh, span, style);
    const int bays = std::max(1, int(length / style.bay_m));
    const double bay = length / bays;
    const double ground_storey = std::min(style.ground_storey_m, height);
    const int storeys = 1 + std::max(0, int((height - ground_storey) / style.storey_m + 1e-6));
    writer.wall(0, length, span.y0, span.ground_y);  // the plinth that follows the slope

    double y = span.ground_y;
    for (int storey = 0; storey < storeys; ++storey) {
        const bool ground = storey == 0;
        const double tall = ground ? ground_storey : style.storey_m;
        for (int i = 0; i < bays; ++i) {
            const double s0 = i * bay, s1 = s0 + bay;
            const bool door_here = ground && door && i == bays / 2;
            double width = std::clamp(style.window_width * bay, 0.5, bay - 0.3);
            double b0 = y + style.sill * tall, b1 = b0 + style.window_height * tall;
            std::uint32_t pane = style.glass, pane_color = style.glass_color;
            double recess = style.recess_m;
            if (ground && style.shops) {
                width = bay - 0.5;
                b0 = y + 0.4, b1 = y + tall - 0.7;
                recess = 0.3;
            }
            if (door_here) {
                width = std::min(style.shops ? 1.8 : 1.1, bay - 0.4);
                b0 = y + 0.02, b1 = y + std::min(2.2, tall - 0.3);
                pane = style.door, pane_color = style.door_color;
                recess = 0.2;
            }
            b1 = std::min(b1, y + tall - 0.12);
            const double a0 = s0 + 0.5 * (bay - width), a1 = a0 + width;
            const std::uint64_t place = hash_mix(seed, storey, i);
            if (!door_here && pane_color == style.glass_color) {
                // Panes differ a little: curtains, reflections.
                const Vec3 base(float(pane_color & 255) / 255.0f, float(pane_color >> 8 & 255) / 255.0f,
                                float(pane_color >> 16 & 255) / 255.0f);
                pane_color = pack_color(base * float(0.75 + 0.25 * hash_unit(place, 1)));
            }
            const bool balcony = !ground && bay > 2.0 && hash_unit(place, 2) < style.balcony_share;
            if (balcony) b0 = y + 0.05;
            writer.opening(s0, s1, y, y + tall, a0, a1, b0, b1, recess, pane, pane_color);
            if (door_here)
                writer.box(a0 - 0.25, a1 + 0.25, b1 + 0.12, b1 + 0.24, 0, 0.7, style.trim, style.trim_color);
            else if (!(ground && style.shops) && !balcony)
                add_window_trim(writer, style, a0, a1, b0, b1);
            if (balcony) add_balcony(writer, style, s0 + 0.1, s1 - 0.1, y);
        }
        y += tall;
        if (style.ledges && storey + 1 < storeys)
            writer.box(0, length, y - 0.14, y, 0, 0.1, style.trim, style.trim_color, true);
        if (ground && style.shops) writer.box(0, length, y - 0.35, y - 0.05, 0, 0.18, style.trim, style.trim_color);
    }
    writer.wall(0, length, y, span.y1);
    if (style.pilasters)
        for (int i = 0; i <= bays; ++i) {
            const double s = std::clamp(i * bay, 0.2, length - 0.2);
            writer.box(s - 0.2, s + 0.2, span.ground_y, span.y1, 0, 0.22, style.trim, style.trim_color);
        }
    if (style.cornice) writer.box(0, length, span.y1 - 0.35, span.y1 + 0.02, 0, 0.3, style.trim, style.trim_color);
}

void add_box(MeshBuilder& mesh, const DVec2& center, const DVec2& axis, const DVec2& half, double y0, double y1,
             std::uint32_t material, std::uint32_t color, double tile_m) {
    const DVec2 left{-axis.y, axis.x};
    const DVec2 corners[4] = {center - axis * half.x - left * half.y, center + axis * half.x - left * half.y,
                              center + axis * half.x + left * half.y, center - axis * half.x + left * half.y};
    const float high = float((y1 - y0) / tile_m);
    for (int i = 0; i < 4; ++i) {
        const DVec2 &p = corners[i], &q = corners[(i + 1) % 4];
        const float wide = float(glm::length(q - p) / tile_m);
        mesh.flat_quad({world_from_plan(p, y0), world_from_plan(q, y0), world_from_plan(q, y1), world_from_plan(p, y1)},
                       {Vec2(0, 0), Vec2(wide, 0), Vec2(wide, -high), Vec2(0, -high)}, material, color);
    }
    const Vec2 top(half * 2.0 / tile_m);
    mesh.flat_quad({world_from_plan(corners[0], y1), world_from_plan(corners[1], y1), world_from_plan(corners[2], y1),
                    world_from_plan(corners[3], y1)},
                   {Vec2(0, 0), Vec2(top.x, 0), Vec2(top.x, -top.y), Vec2(0, -top.y)}, material, color);
}

}  // namespace ff::cook
