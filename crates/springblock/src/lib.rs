//! The spring-block model of sliding friction
