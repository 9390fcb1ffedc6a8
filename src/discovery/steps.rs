//! The steps of a discovery, told to whoever listens: it takes minutes.

use std::cell::RefCell;

/// A listener.
type Listener = Box<dyn Fn(&str)>;

thread_local! {
    static LISTENER: RefCell<Option<Listener>> = const { RefCell::new(None) };
}

/// Does `work` and tells its steps, as they begin on this thread, to `listener`.
pub fn telling_steps<T>(listener: impl Fn(&str) + 'static, work: impl FnOnce() -> T) -> T {
    let before = LISTENER.replace(Some(Box::new(listener)));
    let done = work();
    LISTENER.replace(before);
    done
}

/// A step begins.
pub(crate) fn step(text: &str) {
    LISTENER.with_borrow(|listener| listener.iter().for_each(|listener| listener(text)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::rc::Rc;

    #[test]
    fn steps_are_told_to_the_listener_alone() {
        let told = Rc::new(RefCell::new(Vec::new()));
        let own = Rc::clone(&told);
        let listener = move |text: &str| own.borrow_mut().push(text.to_owned());
        assert_eq!(
            telling_steps(listener, || {
                step("one");
                3
            }),
            3
        );
        step("two");
        assert_eq!(*told.borrow(), ["one"]);
    }
}
