#include "engine/gl/timer.h"

namespace ff::gl {

void detail::delete_query(GLuint id) {
    glDeleteQueries(1, &id);
}

Timer Timer::make() {
    Timer timer;
    for (auto& query : timer.queries_) {
        GLuint id = 0;
        glCreateQueries(GL_TIME_ELAPSED, 1, &id);
        query = Object<detail::delete_query>(id);
    }
    return timer;
}

void Timer::begin() {
    if (begun_ - read_ == kInFlight) ++read_;  // nobody asked: the oldest is lost
    glBeginQuery(GL_TIME_ELAPSED, queries_[begun_ % kInFlight].id());
}

void Timer::end() {
    glEndQuery(GL_TIME_ELAPSED);
    ++begun_;
}

std::optional<double> Timer::poll_ms() {
    std::optional<double> newest;
    while (read_ != begun_) {
        const GLuint id = queries_[read_ % kInFlight].id();
        GLint available = 0;
        glGetQueryObjectiv(id, GL_QUERY_RESULT_AVAILABLE, &available);
        if (!available) break;
        GLuint64 nanoseconds = 0;
        glGetQueryObjectui64v(id, GL_QUERY_RESULT, &nanoseconds);
        newest = double(nanoseconds) * 1e-6;
        ++read_;
    }
    return newest;
}

}  // namespace ff::gl
